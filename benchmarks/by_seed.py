"""Benches measured one after the other, each drawn from a seed, their rows kept in a CSV file as they come."""

import csv
from collections.abc import Callable, Sequence
from pathlib import Path

from modallab.core.errors import ModallabError

Rows = list[list[object]]


def kept_in(out: Path) -> Rows:
    """Rows of a run that ended early, which goes on."""
    if not out.exists():
        return []
    with out.open(newline="", encoding="utf-8") as file:
        return [[int(row[0]), *row[1:]] for row in list(csv.reader(file))[1:]]


def measure(
    rows_of: Callable[[int], Rows],
    columns: Sequence[str],
    summary: Callable[[Rows], str],
    first: int,
    count: int,
    out: Path,
) -> None:
    """Write the rows of each seed, and print what all come to.

    Args:
        rows_of: the rows of a seed, which each begins with.
        columns: their names.
        summary: of all rows.
        first: seed.
        count: of seeds.
        out: the CSV file.
    """
    rows = kept_in(out)
    for seed in range(max([first - 1, *(int(str(r[0])) for r in rows)]) + 1, first + count):
        try:
            rows += rows_of(seed)
        except ModallabError as error:
            # A bench whose hits land too far off is not measured: on a real one somebody would look at it.
            print(f"{seed}: {error}", flush=True)
            continue
        with out.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows([[f"{v:.7g}" if isinstance(v, float) else v for v in row] for row in rows])
        print(summary(rows), flush=True)
