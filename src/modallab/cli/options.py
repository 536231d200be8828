"""Options that several commands share."""

from typing import Any

JSON_HELP = "write the {} as JSON; - is standard output, and all else then goes to standard error"


def add_saying(command: Any) -> None:
    """Add `--quiet`; the command asks `cli.saying` where its words go."""
    command.add_argument(
        "--quiet", dest="hush", action="store_true", help="say nothing but errors, and what was asked for by --json -"
    )
