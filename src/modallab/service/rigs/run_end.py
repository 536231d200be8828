"""Who reports that a run has ended: one of those who may find it out, once."""

from collections.abc import Generator
from contextlib import contextmanager
from threading import Lock
from typing import Protocol


class Followed(Protocol):
    """A run while a controller follows it."""

    run: str
    """Its name; "" until it has begun."""


class Ends:
    """Runs that are followed, and runs whose end was reported. From any thread."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._followed: list[Followed] = []
        self._reported: set[str] = set()

    @contextmanager
    def following(self, active: Followed) -> Generator[None]:
        """While this lasts, who follows the run reports its end, and nobody else."""
        with self._lock:
            self._followed.append(active)
        try:
            yield
        finally:
            with self._lock:
                self._followed.remove(active)

    def notify(self, run: str) -> bool:
        """Whether this end is to be reported: nobody has."""
        with self._lock:
            new = run not in self._reported
            self._reported.add(run)
            return new

    def left_alone(self, run: str) -> bool:
        """Whether nobody follows the run, nor one that might yet turn out to be it."""
        with self._lock:
            return all(active.run not in ("", run) for active in self._followed)
