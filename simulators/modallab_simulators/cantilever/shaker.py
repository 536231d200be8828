"""The shaker: generator with a clock of its own, power amplifier, force at one point."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.bench.fall import fall_s, fall_volts
from modallab.bench.protocol import Burst
from modallab.core.arrays import Real


@dataclass(frozen=True, slots=True)
class Emission:
    """A burst on the output.

    Attributes:
        burst: as it was asked for.
        start_s: on the converter's clock.
        clock: how fast the generator's clock runs relative to the converter's, less one.
        cut_s: when it was brought to zero before its end, or None.
        straight: whether it rises along a straight line, not along a cosine.
    """

    burst: Burst
    start_s: float
    clock: float
    cut_s: float | None = None
    straight: bool = False

    @property
    def end_s(self) -> float:
        """From here on the output is exactly 0 V."""
        whole = self.start_s + self.burst.duration_s / (1 + self.clock)
        if self.cut_s is None or self.cut_s >= whole:
            return whole
        return self.cut_s + fall_s(self._at(self.cut_s), self.burst.amplitude_v)

    def cut(self, at_s: float) -> "Emission":
        """The same, brought to zero at `at_s` unless it was before."""
        return self if self.cut_s is not None else replace(self, cut_s=at_s)

    def volts(self, times_s: Real) -> Real:
        """Output in V: a sine under its taper, or what falls from it; exactly 0 outside the burst."""
        wave = self._wave(times_s)
        if self.cut_s is not None:
            falling = fall_volts(times_s - self.cut_s, self._at(self.cut_s), self.burst.amplitude_v)
            wave = np.where(times_s < self.cut_s, wave, falling)
        return np.where((times_s > self.start_s) & (times_s < self.end_s), wave, 0.0)

    def _at(self, time_s: float) -> float:
        return float(self._wave(np.array([time_s]))[0])

    def _wave(self, times_s: Real) -> Real:
        own = (times_s - self.start_s) * (1 + self.clock)
        return self.burst.amplitude_v * np.sin(2 * np.pi * self.burst.frequency_hz * own) * self._taper(own)

    def _taper(self, own_s: Real) -> Real:
        burst = self.burst
        if burst.ramp_s == 0:
            return np.ones_like(own_s)
        edge = np.clip(np.minimum(own_s, burst.duration_s - own_s) / burst.ramp_s, 0, 1)
        return edge if self.straight else (1 - np.cos(np.pi * edge)) / 2
