"""How long a process has given no sign of life, distinguished from a machine that lets no process run."""

import time
from collections.abc import Callable

AT_MOST = 5.0
"""However busy the machine: so many times the time-out, by the clock, is too long."""


class HeartbeatTimer:
    """Times how long another process has given no sign of life.

    On a busy machine a living process gave no sign of life for two seconds. Whoever listens was kept waiting as well
    then; so between two looks at most one long look's time is counted. And a process that has used the processor since
    the last look is not frozen, though it did not get to speak: that time is not counted either.
    """

    def __init__(self, allowed_s: float, look_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin.

        Args:
            allowed_s: a counted time longer than this is too long.
            look_s: between two looks, if nobody is kept waiting.
            clock: monotonic, in seconds.
        """
        self._allowed_s = allowed_s
        self._count_s = 2.0 * look_s
        self._clock = clock
        self._looked_s = clock()
        self._heard_s = self._looked_s
        self._used_s = 0.0
        self.counted_s = 0.0

    def look(self, heard_s: float, used_s: float) -> bool:
        """Look again. Whether the other has given no sign of life for too long.

        Args:
            heard_s: when it was heard last.
            used_s: of the processor, by it and so far.
        """
        now = self._clock()
        passed = min(now - self._looked_s, self._count_s)
        self._looked_s = now
        if heard_s != self._heard_s:
            self._heard_s, self.counted_s = heard_s, 0.0
        elif used_s == self._used_s:
            self.counted_s += passed
        self._used_s = used_s
        return self.counted_s > self._allowed_s or now - heard_s > AT_MOST * self._allowed_s
