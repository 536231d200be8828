"""Where a command says what it says, and whether it shows how far it is."""

import argparse
import json
from pathlib import Path

from rich.console import Console

from modallab.cli.outputs import OUT
from modallab.formats.atomic import replacing


class _Nowhere:
    def write(self, text: str) -> int:
        return len(text)

    def flush(self) -> None: ...


def console_of(arguments: argparse.Namespace) -> Console:
    """Standard output; standard error where that takes JSON; nothing at all with `--quiet`."""
    if arguments.hush:
        return Console(file=_Nowhere())  # pyright: ignore[reportArgumentType]  # all of a file that rich asks for
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
    with replacing(path) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")
