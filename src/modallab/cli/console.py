"""Where a command says what it says, and whether it shows how far it is."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from modallab.cli.outputs import OUT
from modallab.core.documents.pages import EventView
from modallab.formats.atomic import write_text

if TYPE_CHECKING:
    from modallab.reporting.modification_table import TableRows


class _DiscardedOutput:
    def write(self, text: str) -> int:
        return len(text)

    def flush(self) -> None: ...


def console_of(arguments: argparse.Namespace) -> Console:
    """Standard output; standard error where that takes JSON; nothing at all with `--quiet`."""
    if getattr(arguments, "hush", False):
        return Console(file=_DiscardedOutput())  # pyrefly: ignore[bad-argument-type]  # all of a file that rich asks for
    return Console(stderr=getattr(arguments, "json", None) == OUT)


def write_json(path: Path, document: object) -> None:
    """Write a document as JSON: whole or not at all, or to standard output for `-`.

    Raises:
        StorageError: the file cannot be written.
    """
    text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    if path == OUT:
        print(text, end="")
        return
    write_text(path, text)


def show_rows(arguments: argparse.Namespace, rows: "TableRows") -> None:
    """Print a table, and beneath it what is to be said."""
    from modallab.reporting.plain_table import plain_table

    console = console_of(arguments)
    console.print(plain_table(rows.headings, rows.rows))
    console.print(rows.caption, markup=False, highlight=False)


class ProgressDisplay:
    """Progress bars, one a run, and what the operator should know."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bars = Progress(
            TextColumn("{task.description:<28}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=console,
        )
        self._tasks: dict[str, TaskID] = {}
        self._said = set[str]()

    def notify(self, event: EventView) -> None:
        """Show an event."""
        said = event.content
        if event.kind == "progress":
            if event.run not in self._tasks:
                self._tasks[event.run] = self._bars.add_task(said["what"], total=said["total"])
            self._bars.update(self._tasks[event.run], completed=said["done"], description=said["what"])
        elif event.kind == "hit_rejected":
            self._say(f"  hit at point {said['point']} rejected: {said['reason']}")
        elif event.kind in ("notice", "failed") and said["what"] not in self._said:
            # What holds of several runs is said once.
            self._said.add(said["what"])
            self._say(f"  {said['what']}")

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False)

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bars.stop()
