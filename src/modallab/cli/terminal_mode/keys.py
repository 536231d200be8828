"""Keys of the operator, and of a pedal, which types a key: whichever it types can be given a meaning."""

import os
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Thread
from typing import Literal, cast, get_args

from modallab.core.errors import ConfigurationError

Meaning = Literal["accept", "undo", "pause", "quit"]

NAMED = {
    "space": " ", "enter": "\r", "tab": "\t", "escape": "\x1b", "backspace": "\x7f",
    "pageup": "\x1b[5~", "pagedown": "\x1b[6~", "up": "\x1b[A", "down": "\x1b[B", "right": "\x1b[C", "left": "\x1b[D",
}  # fmt: skip
"""What a terminal sends for the keys that pedals usually type, besides letters."""

USUAL = "accept=a,undo=u,pause=p,quit=q"
LONGEST = 8


@dataclass(frozen=True, slots=True)
class KeyMap:
    """What the keys mean.

    Attributes:
        meanings: by what the terminal sends.
        names: of the keys, by meaning.
    """

    meanings: dict[str, Meaning]
    names: dict[Meaning, str]

    @classmethod
    def read(cls, text: str) -> "KeyMap":
        """Read `undo=b,accept=pagedown`; what is not named keeps its usual key.

        Raises:
            ConfigurationError: a meaning or a key there is none of, or one key for two.
        """
        names: dict[Meaning, str] = {}
        for part in [*USUAL.split(","), *filter(None, text.split(","))]:
            meaning, _, key = part.partition("=")
            if meaning not in get_args(Meaning) or not (len(key) == 1 or key in NAMED):
                raise ConfigurationError(
                    f"--keys: {part!r}; allowed: {', '.join(get_args(Meaning))}, each = a letter or one of"
                    f" {', '.join(NAMED)}",
                    remedy="write for instance --keys undo=b,accept=pagedown",
                )
            names[cast("Meaning", meaning)] = key
        meanings: dict[str, Meaning] = {NAMED.get(key, key): meaning for meaning, key in names.items()}
        if len(meanings) < len(names):
            raise ConfigurationError(f"--keys: one key for two in {text!r}", remedy="give each action its own key")
        return cls(meanings, names)

    def help(self) -> str:
        """For the screen's last line."""
        return "   ".join(f"{key}: {meaning}" for meaning, key in self.names.items())

    def action_of(self, typed: str) -> Meaning | None:
        """What was typed means; Enter is sent as one of two."""
        return self.meanings.get("\r" if typed == "\n" else typed)


@contextmanager
def listen_to_keys(keys: KeyMap, pressed: Callable[[Meaning], None]) -> Generator[Callable[[], bool]]:
    """Call `pressed`, from a thread, for each key; without a terminal for the first letter of each line of input.

    Yields:
        whether a key can still come, or the input has ended.
    """
    with _single_keys() as read:
        thread = Thread(target=_follow_keys, args=(read, keys, pressed), name="keys", daemon=True)
        thread.start()
        yield thread.is_alive


def _follow_keys(read: Callable[[], str], keys: KeyMap, pressed: Callable[[Meaning], None]) -> None:
    while typed := read():
        meaning = keys.action_of(typed)
        if meaning is not None:
            pressed(meaning)


@contextmanager
def _single_keys() -> Generator[Callable[[], str]]:
    if not sys.stdin.isatty():
        yield _typed_line
    elif sys.platform == "win32":
        import msvcrt

        yield msvcrt.getwch
    else:
        import termios
        import tty

        descriptor = sys.stdin.fileno()
        before = termios.tcgetattr(descriptor)
        tty.setcbreak(descriptor)
        try:
            yield lambda: _typed_key(descriptor)
        finally:
            termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _typed_key(descriptor: int) -> str:
    # A key that is sent as several characters arrives at once.
    return os.read(descriptor, LONGEST).decode(errors="replace")


def _typed_line() -> str:
    try:
        line = sys.stdin.readline()
    except (OSError, ValueError):
        return ""
    return line.strip()[:1] or ("\n" if line else "")
