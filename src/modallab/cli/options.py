"""Options that several commands share."""

import argparse
import re
from difflib import get_close_matches
from typing import Any, NoReturn, Protocol

from modallab.core.errors import ModallabError

_RULES = (
    (r"argument (.+?): invalid float value: (.*)", "{0} is {1}; allowed: a number, with a decimal point", ""),
    (r"argument (.+?): invalid int value: (.*)", "{0} is {1}; allowed: a whole number, without a unit", ""),
    (r"argument (.+?): expected one argument", "{0} has no value", ""),
    (r"argument (.+?): expected at least one argument", "{0} has no value", ""),
    (r"argument (.+?): expected (\d+) arguments", "{0} takes {1} values, with a blank between them", ""),
    (r"argument (.+?): not allowed with argument (.+)", "{0} cannot be combined with {1}", ""),
    (r"the following arguments are required: ([^,]+)", "{0} is missing", ""),
    (r"the following arguments are required: (.+)", "{0} are missing", ""),
    (r"ambiguous option: (.+) could match (.+)", "{0} may mean {1}", "write it out"),
)
"""What argparse says -> what was wrong, and the remedy where the help of the command says no more."""
_CHOICE = re.compile(r"argument (.+?): invalid choice: (.*) \(choose from (.*)\)")
_UNKNOWN = re.compile(r"unrecognized arguments: (.+)")


class UsageError(ModallabError):
    """The command line has a wrong option or value."""

    code = "usage"


class Parser(argparse.ArgumentParser):
    """A parser that raises `UsageError` instead of printing the usage of all options."""

    def error(self, message: str) -> NoReturn:
        """Reject the command line.

        Raises:
            UsageError: always.
        """
        what, remedy = self._said(message)
        raise UsageError(what, remedy=remedy)

    def parse_known_args(  # its overloads differ in types only
        self, args: Any = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        """As argparse's own, but what is left over is rejected by the command that does not know it."""
        found, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"unrecognized arguments: {' '.join(left)}")
        return found, left

    def _said(self, message: str) -> tuple[str, str]:
        """What was wrong, and the remedy."""
        if choice := _CHOICE.fullmatch(message):
            return self._of_choice(*choice.groups())
        if unknown := _UNKNOWN.fullmatch(message):
            return self._of_unknown(unknown[1])
        for pattern, what, remedy in _RULES:
            if found := re.fullmatch(pattern, message):
                return what.format(*found.groups()), remedy or self._form(found[1])
        found = re.fullmatch(r"(?:argument (.+?): )?(.*)", message, re.DOTALL)
        argument, said = found.groups() if found else (None, message)
        return f"{argument} {said}" if argument else said, self._help()

    def _of_choice(self, argument: str, value: str, listed: str) -> tuple[str, str]:
        near = get_close_matches(value.strip("'").lower(), re.findall(r"'([^']*)'", listed), n=1)
        what = f"{argument} is {value}; allowed: {listed.replace(chr(39), '')}"
        return what, f"did you mean {near[0]}? {self._help()}" if near else self._help()

    def _of_unknown(self, words: str) -> tuple[str, str]:
        first = words.split()[0].partition("=")[0]
        near = get_close_matches(first, re.findall(r"--[\w-]+", self._usage()), n=1) if first[0] == "-" else []
        what = f"{self.prog} does not take {words!r}"
        if near:
            return what, f"did you mean {near[0]}? {self._help()}"
        return what, f"put quotation marks around values with blanks; {self._help()}"

    def _form(self, argument: str) -> str:
        """How an option is written, as the usage has it."""
        option = argument.split("/")[0].split(",")[0]
        form = re.search(rf"{re.escape(option)} [^\[\]-]+", self._usage()) if option[:1] == "-" else None
        return f"write it as {form[0].strip()}; {self._help()}" if form else self._help()

    def _usage(self) -> str:
        return " ".join(self.format_usage().split())

    def _help(self) -> str:
        return f"{self.prog} --help lists the options"


JSON_HELP = "write the {} as JSON; - is standard output, and all else then goes to standard error"


class Commands(Protocol):
    """What sub-commands are added to; argparse gives its own class for this no public name."""

    def add_parser(self, name: str, *, help: str) -> Any:  # noqa: A002
        """Add one."""


def add_verbosity_option(command: Any) -> None:
    """Add `--quiet`; the command asks `cli.console` where its words go."""
    command.add_argument(
        "--quiet", dest="hush", action="store_true", help="print only errors, and the output of --json -"
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
