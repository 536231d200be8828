"""Compares two engines on the campaigns that both have answered.

    cd benchmarks/gap
    python -m corpus.compare results/today.csv other.csv [--only pair]

McNemar's exact test: of the campaigns that one of the two has right, the share of either is one half if both are as
good. Seconds are compared campaign by campaign: the geometric mean of second over first.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from pathlib import Path

import numpy as np
from scipy.stats import binomtest

from corpus.campaigns import KINDS
from corpus.results import read

Row = dict[str, str]
Pair = tuple[Row, Row]


@dataclass(frozen=True)
class Compared:
    """Two engines on the same campaigns.

    Attributes:
        both, first, second, neither: campaigns that both, only the first, only the second, none has right.
        p: of McNemar's exact test, two-sided.
        seconds: of the second over the first, geometric mean.
    """

    both: int
    first: int
    second: int
    neither: int
    p: float
    seconds: float


def compared(pairs: Sequence[Pair]) -> Compared:
    marks = [(a["right"] == "1", b["right"] == "1") for a, b in pairs]
    first, second = marks.count((True, False)), marks.count((False, True))
    p = float(binomtest(first, first + second).pvalue) if first + second else 1.0
    seconds = [float(b["seconds"]) / float(a["seconds"]) for a, b in pairs if a["seconds"] and b["seconds"]]
    ratio = float(np.exp(np.mean(np.log(seconds)))) if seconds else nan
    return Compared(marks.count((True, True)), first, second, marks.count((False, False)), p, ratio)


def paired(first: Sequence[Row], second: Sequence[Row]) -> list[Pair]:
    """Rows of the same campaign, in the order of the first."""
    there = {r["id"]: r for r in second}
    return [(r, there[r["id"]]) for r in first if r["id"] in there]


def table(pairs: Sequence[Pair]) -> str:
    lines = [
        "| kind | both | only first | only second | neither | McNemar's p | seconds, second over first |",
        "|---" * 7 + "|",
    ]
    for kind in (*KINDS, "all"):
        of = [pair for pair in pairs if kind in ("all", pair[0]["kind"])]
        if of:
            c = compared(of)
            lines.append(f"| {kind} | {c.both} | {c.first} | {c.second} | {c.neither} | {c.p:.3f} | {c.seconds:.3f} |")
    return "\n".join(lines)


def differing(pairs: Sequence[Pair]) -> str:
    """The campaigns that one of the two has right."""
    lines = ["| campaign | truth | first | second | right | seconds |", "|---" * 6 + "|"]
    for a, b in pairs:
        if a["right"] != b["right"]:
            right = "first" if a["right"] == "1" else "second"
            cells = [a["id"], a["true"] or "none", *(r["said"] or r["verdict"] for r in (a, b)), right]
            lines.append(f"| {' | '.join(cells)} | {a['seconds']} {b['seconds']} |")
    return "\n".join(lines)


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("first", type=Path)
    parser.add_argument("second", type=Path)
    parser.add_argument("--only", nargs="*", default=[], help="kinds or sets")
    a = parser.parse_args(words)
    pairs = paired(read(a.first), read(a.second))
    pairs = [pair for pair in pairs if not a.only or {pair[0]["kind"], pair[0]["set"]} & set(a.only)]
    print(f"{len(pairs)} campaigns that both have answered\n\n{table(pairs)}\n\n{differing(pairs)}")


if __name__ == "__main__":
    main()
