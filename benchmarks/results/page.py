"""Writes docs/benchmarks.md from the figures beside this file.

    python benchmarks/results/page.py          writes the page
    python benchmarks/results/page.py --check  ends with 1 if the page is not that of the figures

A row of a CSV file is one measurement. Of a figure that was measured several times the newest row stands on the page,
of one day the last. `page` says where: `headline`, `yes`, or nothing for a row that stands in the file only.
"""

import csv
import sys
from dataclasses import dataclass, fields
from datetime import date
from pathlib import Path
from textwrap import fill

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "docs" / "benchmarks.md"
TOPICS = {
    "identification": "Identification, recording and service",
    "recording": "Identification, recording and service",
    "service": "Identification, recording and service",
    "gap": "The gap",
    "modification": "Predictions by the modal model",
}
HEAD = """# Measured figures

How good modallab is. *Unseen* figures come from a first run of one program on new trials; *seen* figures
from trials used in development. `benchmarks/results/*.csv` hold all figures,
[history](history/README.md) superseded ones.
Machine: {machine}, beside other work. *By* is the number of the [command](#commands). Put
`python benchmarks/` before a command that does not begin with `modallab` or `python`.
"""


@dataclass(frozen=True)
class Figure:
    """One measurement, as a row of a file; every field is text, and empty where it is not known.

    Raises:
        ValueError: it has no figure, value or command, or a field that is not one of those allowed.
    """

    figure: str
    value: str
    goal: str
    date: str
    commit: str
    seed: str
    seen: str
    machine: str
    command: str
    page: str
    note: str

    def __post_init__(self) -> None:
        if not (self.figure and self.value and self.command):
            raise ValueError(f"{self.figure!r}: a row needs figure, value and command")
        if self.seen not in {"", "seen", "unseen"} or self.page not in {"", "yes", "headline"}:
            raise ValueError(f"{self.figure!r}: seen is {self.seen!r}, page is {self.page!r}")
        if self.date:
            date.fromisoformat(self.date)


def read(file: Path) -> list[Figure]:
    """The rows of a file, in order.

    Raises:
        ValueError: its columns are not those of `Figure`, or a row is wrong.
    """
    with file.open(encoding="utf-8", newline="") as lines:
        rows = csv.DictReader(lines)
        wanted = [field.name for field in fields(Figure)]
        if rows.fieldnames != wanted:
            raise ValueError(f"{file.name}: columns are {rows.fieldnames}, must be {wanted}")
        return [Figure(**row) for row in rows]


def newest(rows: list[Figure]) -> list[Figure]:
    """The newest row of each figure, in the order in which figures occur first; of one day the last row."""
    latest: dict[str, Figure] = {}
    for row in rows:
        before = latest.get(row.figure)
        if before is None or row.date >= before.date:
            latest[row.figure] = row
    return list(latest.values())


def page(by_topic: dict[str, list[Figure]]) -> str:
    """The text of the page: headline first, then a table for each topic."""
    shown = {topic: newest(rows) for topic, rows in by_topic.items()}
    machines = sorted({row.machine for rows in shown.values() for row in rows})
    top = [row for rows in shown.values() for row in rows if row.page == "headline"]
    commands: dict[str, int] = {}
    parts = [HEAD.format(machine="; ".join(machines)), "## Headline", _table(top, commands, noted=True)]
    for title in dict.fromkeys(TOPICS[topic] for topic in shown):
        rows = [row for topic, found in shown.items() if TOPICS[topic] == title for row in found if row.page == "yes"]
        parts += [f"## {title}", _table(rows, commands, noted=False)]
    listed = ". ".join(f"{n}\u00a0`{text.removeprefix('python benchmarks/')}`" for text, n in commands.items())
    wrapped = fill(listed, 200, break_long_words=False, break_on_hyphens=False)
    return "\n".join([*parts, "## Commands\n", f"{wrapped}\n"])


def _table(rows: list[Figure], commands: dict[str, int], *, noted: bool) -> str:
    """A table; commands that it is the first to name get the next numbers."""
    note = " note |" if noted else ""
    lines = [f"| figure | measured | goal | seen | by |{note}", "|---|---|---|---|---|" + ("---|" if noted else "")]
    for row in rows:
        end = f" {row.note} |" if noted else ""
        number = commands.setdefault(row.command, len(commands) + 1)
        lines.append(f"| {row.figure} | {row.value} | {row.goal} | {row.seen} | {number} |{end}")
    return "\n".join(lines) + "\n"


def main(arguments: list[str]) -> int:
    """Write or check the page; the number of the exit."""
    text = page({topic: read(HERE / f"{topic}.csv") for topic in TOPICS})
    if arguments == ["--check"]:
        same = PAGE.read_text(encoding="utf-8") == text
        print("" if same else f"{PAGE} is not that of the figures: run python benchmarks/results/page.py", end="")
        return int(not same)
    PAGE.write_text(text, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
