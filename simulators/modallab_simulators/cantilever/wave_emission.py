"""A wave of any shape on the shaker: the generator's own clock, and the fall when it is cut."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from modallab.bench.protocol import Waveform
from modallab.core.arrays import Real

FALL_S = 0.010
MOST_PER_S = 50.0
"""Of the wave's peak: no part of a fall is steeper."""


@dataclass(frozen=True, eq=False, slots=True)
class WaveEmission:
    """A wave on the output.

    Attributes:
        wave: as it was asked for.
        start_s: on the converter's clock.
        clock: how fast the generator's clock runs relative to the converter's, less one.
        cut_s: when it was cut before its end, or None.
    """

    wave: Waveform
    start_s: float
    clock: float
    cut_s: float | None = None

    @property
    def end_s(self) -> float:
        """From here on the output is exactly 0 V."""
        whole = self.start_s + self.wave.duration_s / (1 + self.clock)
        return whole if self.cut_s is None or self.cut_s >= whole else self.cut_s + self._fall(self.cut_s)[1]

    def cut(self, at_s: float) -> "WaveEmission":
        """The same, falling to zero from `at_s` on, unless it did before."""
        return self if self.cut_s is not None else replace(self, cut_s=at_s)

    def volts(self, times_s: Real) -> Real:
        """Output in V."""
        volts = self._wave(times_s)
        if self.cut_s is None:
            return volts
        from_v, lasts_s = self._fall(self.cut_s)
        part = np.clip((times_s - self.cut_s) / lasts_s, 0, 1)
        return np.where(times_s < self.cut_s, volts, np.where(part < 1, from_v * (1 + np.cos(pi * part)) / 2, 0.0))

    def _wave(self, times_s: Real) -> Real:
        return self.wave.at((times_s - self.start_s) * (1 + self.clock))

    def _fall(self, at_s: float) -> tuple[float, float]:
        from_v = float(self._wave(np.array([at_s]))[0])
        peak = float(np.abs(self.wave.samples).max()) or 1.0
        return from_v, max(FALL_S, pi / 2 * abs(from_v) / (MOST_PER_S * peak))
