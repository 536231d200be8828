"""Where a command says what it says, and whether it shows how far it is."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from modallab.cli.outputs import OUT
from modallab.formats.atomic import write_text

if TYPE_CHECKING:
    from modallab.reporting.modified_table import TableRows


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
