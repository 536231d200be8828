"""Sixty campaigns of the own bench as built whose truth nobody has read: drawn and sealed, opened once.

    cd benchmarks/gap
    python -m corpus.sealed FOLDER

draws them by numbers of the system's own chance, seals each truth by `modallab.blind.seal` in FOLDER, and writes
`sealed.csv`: name, hash and the sealed text, packed. It prints no truth. What is in FOLDER is not drawn again.
`python -m corpus.score --sealed` opens them: see the README.
"""

import argparse
import base64
import csv
import json
import secrets
import tempfile
import zlib
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from corpus.campaigns import Entry
from modallab.blind.draw import NONE, PAIR, Draw, make
from modallab.blind.seal import SEALED as FOLDER
from modallab.blind.seal import opened, publish, seal, sealed_hash
from modallab.blind.trial_bench import trial_bench
from modallab.core.effects import catalogue
from modallab.core.errors import DataError

LIST = Path(__file__).parent / "sealed.csv"
OPENED = Path(__file__).parent / "opened.csv"
SEALED = "sealed"
COUNTS = {"single": 26, PAIR: 12, NONE: 10, "outside": 12}
TOLERANCES = "usual"
ASKED = "asked.json"


def asked(folder: Path) -> list[dict[str, Any]]:
    """What is asked of each draw, in an order that says nothing: chosen once, kept beside the seals."""
    place = folder / ASKED
    if not place.exists():
        chance = secrets.SystemRandom()
        outside = [name for name in trial_bench().kinds() if name not in catalogue()]
        effects = chance.sample(list(catalogue()), COUNTS["single"]) + [PAIR] * COUNTS[PAIR] + [NONE] * COUNTS[NONE]
        effects += [chance.choice(outside) for _ in range(COUNTS["outside"])]
        chance.shuffle(effects)
        listed = [{"effect": effect, "seed": secrets.randbits(48)} for effect in effects]
        folder.mkdir(parents=True, exist_ok=True)
        place.write_text(json.dumps(listed), encoding="utf-8")
    return json.loads(place.read_text(encoding="utf-8"))


def draw(folder: Path) -> None:
    """Draw and seal what is not sealed yet, and publish the hashes once all are."""
    listed = {f"sealed_{n:02d}": what for n, what in enumerate(asked(folder))}
    for name, what in listed.items():
        if sealed_hash(folder, name) is None:
            truth = make(Draw(name, what["effect"], what["seed"], TOLERANCES), later=False).truth["effects"]
            seal(folder, name, what | {"effects": truth})
            print(f"{name} sealed", flush=True)
    hashes = {name: str(sealed_hash(folder, name)) for name in listed}
    whole = publish(folder, {"counts": COUNTS, "tolerances": TOLERANCES}, hashes)
    write(LIST, folder, hashes)
    print(f"{len(hashes)} sealed, SHA-256 {whole}")


def write(file: Path, folder: Path, hashes: dict[str, str]) -> None:
    """The sealed texts of a folder as one file, in which no truth can be read."""
    with file.open("w", encoding="utf-8", newline="") as target:
        writer = csv.writer(target, lineterminator="\n")
        writer.writerow(("id", "hash", "packed"))
        for name, of in hashes.items():
            text = (folder / FOLDER / f"{name}.json").read_bytes()
            writer.writerow((name, of, base64.b85encode(zlib.compress(text, 9)).decode()))


def rows(file: Path = LIST) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as source:
        return list(csv.DictReader(source))


def entries(file: Path = LIST) -> list[Entry]:
    """Sealed campaigns: neither their kind nor their effects are known before they are made."""
    return [Entry(row["id"], SEALED, "", SEALED, "", "", "unseen") for row in rows(file)]


def unsealed(entry: Entry, file: Path = LIST) -> Entry:
    """With what is in its seal, whose hash is checked.

    Raises:
        DataError: the truth is not the one that was sealed.
    """
    listed = rows(file)
    packed = next(row["packed"] for row in listed if row["id"] == entry.id)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        publish(folder, {}, {row["id"]: row["hash"] for row in listed})
        (folder / FOLDER).mkdir()
        (folder / FOLDER / f"{entry.id}.json").write_bytes(zlib.decompress(base64.b85decode(packed)))
        truth = opened(folder, entry.id)
    effects = json.dumps(truth["effects"])
    return Entry(entry.id, SEALED, "", TOLERANCES, truth["effect"], str(truth["seed"]), "unseen", effects=effects)


def opened_before(engine: str, commit: str) -> bool:
    """Note who opens the seals, and give whether another program has done so: then they are no longer unseen.

    Raises:
        DataError: the program is not committed, so that nobody could say which it was.
    """
    if commit.endswith("+"):
        raise DataError("the program has changed since its commit", where=commit, remedy="commit it, and open then")
    if not OPENED.exists():
        OPENED.write_text(f"date,engine,commit\n{datetime.now(UTC).date().isoformat()},{engine},{commit}\n")
    with OPENED.open(encoding="utf-8", newline="") as source:
        first = next(csv.DictReader(source))
    return (first["engine"], first["commit"]) != (engine, commit)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    draw(arguments.folder)


if __name__ == "__main__":
    main()
