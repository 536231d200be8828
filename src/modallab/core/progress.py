"""How far a long computation is: said where it is known, heard by whoever asked for the computation.

A context variable, so that the numerics in between neither pass it on nor depend on who listens.
"""

from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

Item = TypeVar("Item")
Listener = Callable[[float, str], None]
"""Takes the share that is done, 0 to 1, and what is being done, in words."""

_LISTENER: ContextVar[Listener | None] = ContextVar("progress", default=None)


@contextmanager
def report_progress_to(listener: Listener) -> Generator[None]:
    """While this lasts, `listener` hears how far what is computed in it is; the share never falls.

    What is tried again, because it did not lead far enough, is no step back for who waits.
    """
    most = 0.0

    def forward(share: float, words: str) -> None:
        nonlocal most
        most = max(most, share)
        listener(most, words)

    before = _LISTENER.set(forward)
    try:
        yield
    finally:
        _LISTENER.reset(before)


@contextmanager
def part_of_progress(begin: float, end: float, stage: str = "") -> Generator[None]:
    """What is computed in this is the work from `begin` to `end` of the whole; it is in `stage` unless it says more."""
    outer = _LISTENER.get()
    if outer is None:
        yield
        return

    def scaled(share: float, words: str) -> None:
        outer(begin + (end - begin) * min(max(share, 0.0), 1.0), ": ".join(filter(None, (stage, words))))

    with report_progress_to(scaled):
        scaled(0.0, "")
        yield
        scaled(1.0, "")


def report_progress(share: float, stage: str = "") -> None:
    """So much of the work is done; this is being done now."""
    listener = _LISTENER.get()
    if listener is not None:
        listener(share, stage)


def count_progress(items: Iterable[Item], total: int, stage: str = "") -> Generator[Item]:
    """Yield the items and report after each how many of `total` are done."""
    for n, item in enumerate(items, 1):
        report_progress(n / total, f"{stage}, {n} of {total}")
        yield item
