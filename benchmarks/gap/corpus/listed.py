"""Writes `campaigns.csv`: which campaigns the corpus holds. Run once; what is listed stays.

cd benchmarks/gap
python -m corpus.listed PRACTICE
"""

import argparse
import hashlib
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import count, product
from pathlib import Path

import yaml
from other_structures import KINDS as CHANGES

from corpus.campaigns import LIST, Entry, entries, is_stepped, kind_of_truth, write
from corpus.made import kept_at, made
from corpus.named import named
from modallab.blind.draw import NONE, PAIR, pair_names
from modallab.blind.trial_bench import trial_bench

BUILT = {"none": 30, "single": 2, "stepped": 3, "unknown": 3}
"""Own benches as built: so many without effect, and of each effect."""
PAIRS = {0: 19, 1: 7}
"""How many pairs have so many effects that are stepped."""
IDEAL = {"none": 3, "single": 1, "stepped": 1, "unknown": 0}
IDEAL_PAIRS = {0: 2, 1: 1}
IDEAL_UNKNOWN = ("torsion", "preamp_lag", "dropouts")


def seed_of(name: str) -> int:
    """Of everything in a campaign of this name."""
    return int.from_bytes(hashlib.sha256(f"modallab corpus {name}".encode()).digest()[:6])


def of_folders(practice: Path) -> Iterator[Entry]:
    for folder in (practice, practice.parent / f"{practice.name}_rough"):
        for file in sorted(folder.glob("*/truth.yaml")):
            names = [e["effect"] for e in yaml.safe_load(file.read_text(encoding="utf-8"))["effects"]]
            yield Entry(file.parent.name, folder.name, kind_of_truth(names), "folder", "", "", "seen")


def of_own_bench(
    of: str, how: str, counts: dict[str, int], pairs: dict[int, int], more: tuple[str, ...] = ()
) -> list[Entry]:
    """The first of each effect before the second."""
    names = [NONE] * counts["none"] + [n for n in trial_bench().kinds() for _ in range(counts[_kind(n)])] + list(more)
    numbered = [(name, names[:k].count(name)) for k, name in enumerate(names)]
    listed = [_own(f"{of}_{name}_{n}", of, how, name) for name, n in sorted(numbered, key=lambda pair: pair[1])]
    return listed + [e for stepped, wanted in pairs.items() for e in _pairs(of, how, stepped, wanted)]


def _kind(name: str) -> str:
    return kind_of_truth([name])


def _own(name: str, of: str, how: str, effect: str) -> Entry:
    return Entry(name, of, "none" if effect == NONE else _kind(effect), how, effect, str(seed_of(name)), "unseen")


def _pairs(of: str, how: str, stepped: int, wanted: int) -> list[Entry]:
    """The first pairs, by number, that have so many stepped effects."""
    found: list[Entry] = []
    for number in count():
        name = f"{of}_pair_{number}"
        if sum(map(is_stepped, pair_names(seed_of(name)))) == stepped:
            found.append(Entry(name, of, "pair", how, PAIR, str(seed_of(name)), "unseen"))
        if len(found) == wanted:
            return found
    raise AssertionError


def structures() -> Iterator[Entry]:
    """Of each bench and way of making the reference two of each change and two without any."""
    for number, effect, bench, reference in product(range(2), (*CHANGES, "none"), ("plate", "tube"), ("", " computed")):
        how = bench + reference
        name = f"{how.replace(' ', '_')}_{effect}_{number}"
        yield Entry(name, "structures", "structure", how, effect, str(seed_of(name) % 2**32), "unseen")


def with_effects(entry: Entry, draw: bool) -> Entry:
    """With what its seed draws, once it has been made."""
    if entry.effects or entry.how not in ("usual", "none"):
        return entry
    if entry.effect == NONE:
        return replace(entry, effects="[]")
    place = kept_at(entry).with_suffix(".json")
    if draw and not place.exists():
        made(entry)
    return replace(entry, effects=place.read_text(encoding="utf-8")) if place.exists() else entry


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("practice", type=Path)
    parser.add_argument("--draw", action="store_true")
    parser.add_argument("--minutes", type=float, default=60.0, help="no campaign is drawn after these")
    arguments = parser.parse_args()
    listed = [
        *of_folders(arguments.practice),
        *of_own_bench("own_built", "usual", BUILT, PAIRS),
        *of_own_bench("own_ideal", "none", IDEAL, IDEAL_PAIRS, IDEAL_UNKNOWN),
        *structures(),
        *named(),
    ]
    known = {e.id: e for e in entries()} if LIST.exists() else {}
    listed = [known.get(e.id, e) for e in listed] + [e for e in known.values() if e.id not in {m.id for m in listed}]
    end = time.monotonic() + 60 * arguments.minutes
    cheap_first = sorted(listed, key=lambda e: e.kind == "stepped")
    drawn = {e.id: with_effects(e, arguments.draw and time.monotonic() < end) for e in cheap_first}
    write(LIST, [drawn[e.id] for e in listed])
    print(f"{sum(e.how in ('usual', 'none') and not e.effects for e in entries())} campaigns are left to draw")


if __name__ == "__main__":
    main()
