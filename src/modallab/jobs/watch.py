"""Who holds jobs and gives no sign of life any more, by the watcher's own monotonic clock."""

import time
from collections.abc import Callable, Mapping

Mark = tuple[int, float]
"""Fence and beat of a job that is held: one of them changes with every sign of its holder."""


class Watch:
    """Times how long each job's mark has stayed the same.

    No clock on the wall is asked, neither the machine's nor the database's: a clock that is set ends no lease and
    prolongs none. Between two looks at most a part of the lease is counted, so that a watcher that slept, or a database
    that answered nobody, is not taken for the time-out of a holder.
    """

    def __init__(self, lease_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._lease_s = lease_s
        self._clock = clock
        self._looked_s = clock()
        self._marks: dict[str, Mark] = {}
        self._timeout_s: dict[str, float] = {}

    def look(self, held: Mapping[str, Mark]) -> dict[str, Mark]:
        """Note what is held now; those of them without a sign of life for longer than the lease, with their marks."""
        now = self._clock()
        passed = min(now - self._looked_s, self._lease_s / 5)
        self._looked_s = now
        self._timeout_s = {
            job: self._timeout_s[job] + passed if self._marks.get(job) == mark else 0.0 for job, mark in held.items()
        }
        self._marks = dict(held)
        return {job: mark for job, mark in held.items() if self._timeout_s[job] > self._lease_s}
