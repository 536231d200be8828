"""The shaker: generator with a clock of its own, what it can play, its waves, power amplifier, force at one point."""

from dataclasses import dataclass, replace
from math import isfinite, pi

import numpy as np

from modallab.bench.protocol import Burst, Waveform
from modallab.bench.ramp_down import ramp_down_s, ramp_down_volts
from modallab.core.arrays import Real
from modallab.core.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class BurstOutput:
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
        return self.cut_s + ramp_down_s(self._at(self.cut_s), self.burst.amplitude_v)

    def cut(self, at_s: float) -> "BurstOutput":
        """The same, brought to zero at `at_s` unless it was before."""
        return self if self.cut_s is not None else replace(self, cut_s=at_s)

    def volts(self, times_s: Real) -> Real:
        """Output in V: a sine under its taper, or what falls from it; exactly 0 outside the burst."""
        wave = self._wave(times_s)
        if self.cut_s is not None:
            falling = ramp_down_volts(times_s - self.cut_s, self._at(self.cut_s), self.burst.amplitude_v)
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


FALL_S = 0.010
MOST_PER_S = 50.0
"""Of the wave's peak: no part of a fall is steeper."""


@dataclass(frozen=True, eq=False, slots=True)
class WaveOutput:
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

    def cut(self, at_s: float) -> "WaveOutput":
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


OUTPUT_RANGE_V = 10.0


def require_burst(burst: Burst, rate_hz: float) -> None:
    """Reject a sine that the output cannot play.

    Raises:
        ConfigurationError: its frequency, amplitude or times are out of range.
    """
    problems = {
        "frequency_hz": 0 < burst.frequency_hz < rate_hz / 2,
        "amplitude_v": 0 < burst.amplitude_v <= OUTPUT_RANGE_V,
        "ramp_s": isfinite(burst.ramp_s) and burst.ramp_s >= 0,
        "hold_s": isfinite(burst.hold_s) and burst.hold_s >= 0,
    }
    wrong = [f"{name} = {getattr(burst, name)}" for name, good in problems.items() if not good]
    if wrong or burst.duration_s == 0:
        raise ConfigurationError(
            f"a burst of {', '.join(wrong) or 'no duration'}",
            remedy=f"frequency above 0 to half the rate, amplitude above 0 to {OUTPUT_RANGE_V:g} V, times from 0",
        )


def require_wave(wave: Waveform, where: str) -> None:
    """Reject a wave that the output cannot play.

    Raises:
        ConfigurationError: it does not begin and end at 0 V, or is beyond the range.
    """
    if not np.abs(wave.samples).max() <= OUTPUT_RANGE_V or wave.samples[0] != 0 or wave.samples[-1] != 0:
        raise ConfigurationError(
            f"a wave up to {np.abs(wave.samples).max():g} V, from {wave.samples[0]:g} to {wave.samples[-1]:g} V",
            where=where,
            remedy=f"let it begin and end at 0 V and stay within {OUTPUT_RANGE_V:g} V",
        )
