"""The time of the simulated bench: the wall's, or that of whoever reads."""

import time


class BenchClock:
    """Seconds since the bench was switched on.

    With `pace` it runs as the clock on the wall does. Without, it stands still until samples are read, and then goes
    on by just as much: a test then takes no time, and repeats itself exactly.
    """

    def __init__(self, pace: bool) -> None:
        self.pace = pace
        self._began_s = time.monotonic()
        self._virtual_s = 0.0

    def now(self) -> float:
        """Bench time in s."""
        return time.monotonic() - self._began_s if self.pace else self._virtual_s

    def read_up_to(self, time_s: float) -> None:
        """Samples up to a time were read: without pace it has then come."""
        self._virtual_s = max(self._virtual_s, time_s)
