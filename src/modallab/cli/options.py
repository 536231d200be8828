"""Options that several commands share."""

import argparse
from typing import Any, Protocol

from modallab.cli.usage import UsageError

JSON_HELP = "write the {} as JSON; - is standard output, and all else then goes to standard error"


class Commands(Protocol):
    """What sub-commands are added to; argparse gives its own class for this no public name."""

    def add_parser(self, name: str, *, help: str) -> Any:  # noqa: A002
        """Add one."""


def add_saying(command: Any) -> None:
    """Add `--quiet`; the command asks `cli.console` where its words go."""
    command.add_argument(
        "--quiet", dest="hush", action="store_true", help="say nothing but errors, and what was asked for by --json -"
    )


def positive_number(text: str) -> float:
    """A number above 0, as the type of an option."""
    value = _finite_number(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"is {text!r}; allowed: more than 0")
    return value


def not_negative(text: str) -> float:
    """A number from 0, as the type of an option."""
    value = _finite_number(text)
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"is {text!r}; allowed: 0 or more")
    return value


def positive_integer(text: str) -> int:
    """A whole number from 1, as the type of an option."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"is {text!r}; allowed: a whole number from 1")
    return value


def require_option(needed: str, **given: object) -> None:
    """Reject options that would have no effect.

    Args:
        needed: what is missing, as it is written.
        given: name of an option -> its value; None where it was not given.

    Raises:
        UsageError: one of them was given.
    """
    for name, value in given.items():
        if value is not None:
            raise UsageError(f"--{name} has no effect without {needed}", remedy=f"add {needed}, or leave out --{name}")


def _finite_number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"is {text!r}; allowed: a number, with a decimal point and without a unit"
        ) from None
