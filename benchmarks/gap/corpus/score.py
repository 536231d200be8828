"""Scores an engine of the diagnosis on the corpus: a row a campaign, as they come.

    cd benchmarks/gap
    python -m corpus.score --out results.csv --minutes 60 --processes 2
    python -m corpus.score --engine package.module:function --only stepped pair/own_built --out other.csv

An engine is a function (campaign, reference) -> diagnosis, see `engines.py`. Rows of the same engine that the file
holds already are kept and not computed again.
"""

import argparse
import csv
import subprocess
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from threading import Lock

import modallab
from corpus.answered import answered
from corpus.campaigns import Entry, chosen, entries, ordered
from corpus.processes import prepare
from corpus.rows import COLUMNS, Row
from modallab.core.errors import DataError

TODAY = "corpus.engines:today"


def read(file: Path) -> list[dict[str, str]]:
    """The rows of a file of results; none where there is none."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as source:
        return list(csv.DictReader(source))


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


class Results:
    """A file of results to which rows are added one by one."""

    def __init__(self, file: Path, engine: str, seen: bool) -> None:
        self._file, self._lock = file, Lock()
        self._same = {"engine": engine, "date": datetime.now(UTC).date().isoformat(), "commit": commit()}
        self._seen = {"seen": "seen"} if seen else {}
        if not file.exists():
            file.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")

    def add(self, row: Row) -> None:
        with self._lock, self._file.open("a", encoding="utf-8", newline="") as target:
            csv.DictWriter(target, COLUMNS, lineterminator="\n").writerow(row | self._same | self._seen)
        print(said(row), flush=True)


def said(row: Row) -> str:
    """A row in words."""
    mark = "right" if row["right"] else "WRONG"
    names = f"{row.get('true') or 'none'} -> {row.get('said') or row['verdict']}"
    seconds, why = row.get("seconds", ""), row.get("error", "")
    return f"{row['id']:24s} {row['kind']:9s} {mark} {seconds:>7} s {names} {why}"


def run(listed: Sequence[Entry], engine: str, results: Results, end: float, processes: int, limit_s: float) -> None:
    """Answer campaigns in their order, and begin none after `end` on the monotonic clock."""
    prepare(engine)

    def one(entry: Entry) -> None:
        if time.monotonic() < end:
            try:
                results.add(answered(entry, engine, limit_s))
            except DataError as error:
                print(f"{entry.id}: {error}", flush=True)

    with ThreadPoolExecutor(processes) as pool:
        list(pool.map(one, listed))


def main(words: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--engine", default=TODAY, help="module:function")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", nargs="*", default=[], help="kinds, sets, kind/set or ids")
    parser.add_argument("--order", choices=("stratified", "file"), default="stratified")
    parser.add_argument("--minutes", type=float, default=60.0, help="no campaign is begun after these")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--limit", type=float, default=900.0, help="processor seconds of a diagnosis at most")
    parser.add_argument("--seen", action="store_true", help="the engine was developed on these campaigns")
    a = parser.parse_args(words)
    there = {row["id"] for row in read(a.out) if row["engine"] == a.engine}
    left = [e for e in ordered(chosen(entries(), a.only), a.order) if e.id not in there]
    end = time.monotonic() + 60 * a.minutes
    run(left, a.engine, Results(a.out, a.engine, a.seen), end, a.processes, a.limit)
    rows = [row for row in read(a.out) if row["engine"] == a.engine]
    print(f"{len(rows)} rows, {len(left) + len(there) - len(rows)} campaigns left; the same command goes on")


if __name__ == "__main__":
    main()
