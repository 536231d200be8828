"""Sixty campaigns of the own bench as built whose truth nobody has read: sealed, not run, opened once.

    cd benchmarks/gap
    python -m corpus.sealed

asks for them by numbers of the system's own chance, seals each by `modallab.blind.seal`, and writes `sealed.csv`: name,
hash and the sealed text, packed. What is sealed is an effect and a seed: all else follows from these when the campaign
is made. It prints none of it, and goes no further where there is a list. `python -m corpus.score --sealed` opens them.
"""

import argparse
import base64
import csv
import secrets
import tempfile
import zlib
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from corpus.campaigns import Entry
from modallab.blind.draw import NONE, PAIR
from modallab.blind.seal import SEALED as FOLDER
from modallab.blind.seal import open_truth, publish_hashes, seal_truth
from modallab.blind.trial_bench import trial_bench
from modallab.core.effects import catalogue
from modallab.core.errors import DataError

LIST = Path(__file__).parent / "sealed.csv"
OPENED = Path(__file__).parent / "opened.csv"
SEALED = "sealed"
COUNTS = {"single": 26, PAIR: 12, NONE: 10, "outside": 12}
TOLERANCES = "usual"


def asked() -> list[dict[str, Any]]:
    """Effects and seeds, in an order that says nothing."""
    chance = secrets.SystemRandom()
    outside = [name for name in trial_bench().kinds() if name not in catalogue()]
    effects = chance.sample(list(catalogue()), COUNTS["single"]) + [PAIR] * COUNTS[PAIR] + [NONE] * COUNTS[NONE]
    effects += [chance.choice(outside) for _ in range(COUNTS["outside"])]
    chance.shuffle(effects)
    return [{"effect": effect, "seed": secrets.randbits(48)} for effect in effects]


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
        publish_hashes(folder, {}, {row["id"]: row["hash"] for row in listed})
        (folder / FOLDER).mkdir()
        (folder / FOLDER / f"{entry.id}.json").write_bytes(zlib.decompress(base64.b85decode(packed)))
        truth = open_truth(folder, entry.id)
    return Entry(entry.id, SEALED, "", TOLERANCES, truth["effect"], str(truth["seed"]), "unseen")


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
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    if LIST.exists():
        raise DataError("there are sealed campaigns", where=str(LIST), remedy="open them, or delete the file")
    with tempfile.TemporaryDirectory() as place:
        hashes = {f"sealed_{n:02d}": seal_truth(Path(place), f"sealed_{n:02d}", what) for n, what in enumerate(asked())}
        write(LIST, Path(place), hashes)
        print(f"{len(hashes)} sealed, SHA-256 {publish_hashes(Path(place), {}, hashes)}")


if __name__ == "__main__":
    main()
