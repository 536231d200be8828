"""Sums up a file of results: by kind, over all, and over what was seen or unseen.

cd benchmarks/gap
python -m corpus.summary results.csv [--only own_built] [--of ENGINE]
"""

import argparse
import json
from collections.abc import Callable, Sequence
from math import nan
from pathlib import Path

import numpy as np

from corpus.campaigns import KINDS
from corpus.results import read
from modallab.blind.score import calibration_of_claims

Row = dict[str, str]
COLUMNS = (
    *("rows", "right", "one named", "false alarms", "unknown flagged", "precision above 0.9", "calibration error"),
    *("intervals hold", "place right", "seconds median", "seconds worst"),
)


def figures(rows: Sequence[Row]) -> dict[str, tuple[float, int]]:
    """Each figure and of how many: shares from 0 to 1, processor seconds."""
    seconds = [float(r["seconds"]) for r in rows if r["seconds"]]
    return {
        "rows": (float(len(rows)), len(rows)),
        "right": _share(rows, lambda r: r["right"] == "1"),
        "one named": _share([r for r in rows if "+" in r["true"]], one_named),
        "false alarms": _share([r for r in rows if not r["true"]], lambda r: r["verdict"] != "no_gap"),
        "unknown flagged": _share([r for r in rows if r["kind"] == "unknown"], lambda r: r["verdict"] == "unknown"),
        "precision above 0.9": _share([r for r in rows if r["claims_right"]], lambda r: r["claims_right"] == "1"),
        "calibration error": (calibration_of_claims(claims(rows))[0] if claims(rows) else nan, len(claims(rows))),
        "intervals hold": _held(rows),
        "place right": _share([r for r in rows if r["place_right"]], lambda r: r["place_right"] == "1"),
        "seconds median": (float(np.median(seconds)) if seconds else nan, len(seconds)),
        "seconds worst": (max(seconds, default=nan), len(seconds)),
    }


def claims(rows: Sequence[Row]) -> list[tuple[float, bool]]:
    """The probability of each effect that was named, and whether it is one of the true ones."""
    said = [(r, json.loads(r["probabilities"] or "{}")) for r in rows]
    return [(p, name in r["true"].split("+")) for r, of in said for name, p in of.items()]


def one_named(row: Row) -> bool:
    """Whether one of the true effects at least is named."""
    return bool(set(row["true"].split("+")) & set(row["said"].split("+")))


def _held(rows: Sequence[Row]) -> tuple[float, int]:
    held = [ok for r in rows for ok in json.loads(r["held"] or "{}").values()]
    return float(np.mean(held)) if held else nan, len(held)


def _share(rows: Sequence[Row], test: Callable[[Row], bool]) -> tuple[float, int]:
    return float(np.mean([test(r) for r in rows])) if rows else nan, len(rows)


def table(rows: Sequence[Row]) -> str:
    """A table in Markdown: a line a kind, one for all, one each for seen and unseen."""
    groups = [(kind, [r for r in rows if r["kind"] == kind]) for kind in KINDS]
    groups += [("all", list(rows)), *((s, [r for r in rows if r["seen"] == s]) for s in ("seen", "unseen"))]
    lines = ["| kind | " + " | ".join(COLUMNS) + " |", "|---" * (len(COLUMNS) + 1) + "|"]
    for name, of in groups:
        if of:
            found = figures(of)
            lines.append(f"| {name} | " + " | ".join(_cell(column, *found[column]) for column in COLUMNS) + " |")
    return "\n".join(lines)


def _cell(column: str, value: float, count: int) -> str:
    if not count:
        return ""
    if column == "rows":
        return str(count)
    if column.startswith("seconds"):
        return f"{value:.1f}"
    if column == "calibration error":
        return f"{value:.3f} of {count}"
    return f"{100 * value:.0f} % of {count}"


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--only", nargs="*", default=[], help="kinds or sets")
    parser.add_argument("--of", help="engine; where the file holds several")
    a = parser.parse_args(words)
    rows = [r for r in read(a.results) if a.of in (None, r["engine"])]
    rows = [r for r in rows if not a.only or {r["kind"], r["set"]} & set(a.only)]
    for engine in dict.fromkeys(r["engine"] for r in rows):
        own = [r for r in rows if r["engine"] == engine]
        print(f"{engine}, commit {', '.join(dict.fromkeys(r['commit'] for r in own))}\n\n{table(own)}\n")
        wrong = [f"{r['id']} ({r['true'] or 'none'} -> {r['said'] or r['verdict']})" for r in own if r["right"] != "1"]
        print(f"wrong, {len(wrong)}: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
