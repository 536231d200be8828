"""A file of results: a row a campaign, added as it comes."""

import csv
import subprocess
from datetime import UTC, datetime
from pathlib import Path
from threading import Lock
from typing import Any

import modallab

COLUMNS = (
    *("id", "set", "kind", "seen", "engine", "date", "commit", "seconds", "verdict", "true", "said", "right"),
    *("in_three", "stage_right", "channel_right", "place_right", "claims_right", "number_error", "held"),
    *("probabilities", "numbers", "intervals", "places", "stage", "x_m", "channels", "candidates"),
    *("gap_without_effects", "gap_after", "held_out_before", "held_out_after", "closed", "error"),
)
Row = dict[str, Any]


def read(file: Path) -> list[dict[str, str]]:
    """The rows of a file of results; none where there is none."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as source:
        return list(csv.DictReader(source))


class Results:
    """Adds rows to a file, each with the engine, the date and the commit.

    Args:
        file: made if it is not there.
        engine: as it is named.
        seen: whether every row says so.
    """

    def __init__(self, file: Path, engine: str, seen: bool) -> None:
        self._file, self._lock = file, Lock()
        self._same = {"engine": engine, "date": datetime.now(UTC).date().isoformat(), "commit": commit()}
        self._seen = {"seen": "seen"} if seen else {}
        if not file.exists():
            file.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")

    def add(self, row: Row) -> None:
        with self._lock, self._file.open("a", encoding="utf-8", newline="") as target:
            csv.DictWriter(target, COLUMNS, lineterminator="\n").writerow(row | self._same | self._seen)
        print(in_words(row), flush=True)


def in_words(row: Row) -> str:
    mark = "right" if row["right"] else "WRONG"
    names = f"{row['true'] or 'none'} -> {row.get('said') or row['verdict']}"
    seconds, why = row.get("seconds", ""), row.get("error", "")
    return f"{row['id']:24s} {row['kind']:9s} {mark} {seconds:>7} s {names} {why}"


def commit() -> str:
    """The commit of the program that runs, with a + where its files have been changed since."""
    folder = Path(modallab.__file__).parent
    try:
        said = [_git(folder, "rev-parse", "--short", "HEAD"), _git(folder, "status", "--porcelain", "--", ".")]
    except (OSError, subprocess.CalledProcessError):
        return modallab.__version__
    return said[0] + ("+" if said[1] else "")


def _git(folder: Path, *words: str) -> str:
    return subprocess.run(["git", "-C", folder, *words], check=True, capture_output=True, text=True).stdout.strip()
