"""Options that several commands share."""

import argparse
from typing import Any

JSON_HELP = "write the {} as JSON; - is standard output, and all else then goes to standard error"


def add_saying(command: Any) -> None:
    """Add `--quiet`; the command asks `cli.saying` where its words go."""
    command.add_argument(
        "--quiet", dest="hush", action="store_true", help="say nothing but errors, and what was asked for by --json -"
    )


def positive(text: str) -> float:
    """A number above 0, as the type of an option."""
    value = _number(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"is {text!r}; allowed: more than 0")
    return value


def not_negative(text: str) -> float:
    """A number from 0, as the type of an option."""
    value = _number(text)
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"is {text!r}; allowed: 0 or more")
    return value


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"is {text!r}; allowed: a number, with a decimal point and without a unit"
        ) from None
