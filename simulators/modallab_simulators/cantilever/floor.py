"""The floor's vibration: a stationary random acceleration of the base."""

from copy import copy

import numpy as np

from modallab.core.arrays import Real

PERIOD_S = 65.536
BAND_HZ = (2.0, 200.0)


class Floor:
    """White between 2 and 200 Hz, repeating only after a minute.

    Args:
        rms_acc: in m/s^2.
        step_s: between internal samples.
        rng: draws the motion.
    """

    def __init__(self, rms_acc: float, step_s: float, rng: np.random.Generator) -> None:
        self._begins = 0
        count = round(PERIOD_S / step_s)
        f = np.fft.rfftfreq(count, step_s)
        inside = (f >= BAND_HZ[0]) & (f <= BAND_HZ[1])
        lines = np.zeros(len(f), dtype=np.complex128)
        lines[inside] = rng.standard_normal((inside.sum(), 2)) @ [1, 1j]
        wave = np.fft.irfft(lines, count)
        self._wave = wave * (rms_acc / np.sqrt(np.mean(wave**2)))

    def starting(self, rng: np.random.Generator) -> "Floor":
        """The same motion, met at another time."""
        other = copy(self)
        other._begins = int(rng.integers(len(self._wave)))
        return other

    def acceleration(self, first: int, count: int) -> Real:
        """In m/s^2 on internal samples from `first`, nothing before the stream begins, (count,)."""
        index = np.arange(first, first + count)
        return np.where(index >= 0, self._wave[(self._begins + index) % len(self._wave)], 0.0)
