"""A software trigger on the rising force, with hysteresis."""

import numpy as np
from numpy.typing import NDArray


class Trigger:
    """Finds the first sample at or above `level` after the signal was below `level - hysteresis`.

    The answer is exact to the sample and does not depend on how the signal is cut into chunks.
    """

    def __init__(self, level: float, hysteresis: float) -> None:
        self._level = level
        self._low = level - hysteresis
        self._armed = False

    def scan(self, signal: NDArray[np.float64]) -> int | None:
        """Index of the trigger in the next (n,) samples, or None. After a trigger it must fall before it can fire."""
        start = 0
        if not self._armed:
            below = np.flatnonzero(signal < self._low)
            if below.size == 0:
                return None
            self._armed = True
            start = int(below[0]) + 1
        above = np.flatnonzero(signal[start:] >= self._level)
        if above.size == 0:
            return None
        self._armed = False
        return start + int(above[0])
