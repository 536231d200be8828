"""Scores an engine of the diagnosis on the corpus: a row a campaign, as they come.

    cd benchmarks/gap
    python -m corpus.score --out results.csv --minutes 60 --processes 2
    python -m corpus.score --engine package.module:function --only stepped pair/own_built --out other.csv

An engine is a function (campaign, reference) -> diagnosis, see `engines.py`. Rows of the same engine that the file
holds already are kept and not computed again.
"""

import argparse
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from corpus import sealed
from corpus.answered import answered
from corpus.campaigns import Entry, chosen, entries, ordered
from corpus.processes import prepare
from corpus.results import Results, commit, read
from corpus.sealed import opened_before
from modallab.core.errors import DataError

TODAY = "corpus.engines:today"


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
    parser.add_argument("--sealed", action="store_true", help="open the sealed campaigns, once: see the README")
    parser.add_argument("--seen", action="store_true", help="the engine was developed on these campaigns")
    a = parser.parse_args(words)
    there = {row["id"] for row in read(a.out) if row["engine"] == a.engine}
    seen = a.seen or (a.sealed and opened_before(a.engine, commit()))
    listed = sealed.entries() if a.sealed else ordered(chosen(entries(), a.only), a.order)
    left = [e for e in listed if e.id not in there]
    end = time.monotonic() + 60 * a.minutes
    run(left, a.engine, Results(a.out, a.engine, seen), end, a.processes, a.limit)
    now = {row["id"] for row in read(a.out) if row["engine"] == a.engine}
    print(f"{len(now)} rows, {sum(e.id not in now for e in left)} campaigns left; the same command goes on")


if __name__ == "__main__":
    main()
