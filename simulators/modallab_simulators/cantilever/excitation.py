"""What drives the beam and when: hits struck or meant, bursts on the shaker, a floor that shakes at random."""

from copy import copy
from dataclasses import dataclass, replace
from math import isfinite, pi
from typing import NamedTuple

import numpy as np

from modallab.bench.protocol import Burst, Waveform
from modallab.bench.ramp_down import ramp_down_s, ramp_down_volts
from modallab.core.arrays import Real
from modallab.core.errors import ConfigurationError
from modallab_simulators.cantilever.hammer import HammerHit
from modallab_simulators.cantilever.loads import BeamLoad


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


PERIOD_S = 65.536
BAND_HZ = (2.0, 200.0)


class FloorMotion:
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

    def starting(self, rng: np.random.Generator) -> "FloorMotion":
        """The same motion, met at another time."""
        other = copy(self)
        other._begins = int(rng.integers(len(self._wave)))
        return other

    def acceleration(self, first: int, count: int) -> Real:
        """In m/s^2 on internal samples from `first`, nothing before the stream begins, (count,)."""
        index = np.arange(first, first + count)
        return np.where(index >= 0, self._wave[(self._begins + index) % len(self._wave)], 0.0)


AMPLIFIER_V = 5.0
"""Voltage to which the overtones of a power amplifier are related."""


class _On(NamedTuple):
    """What plays, and on which shaker, from 0."""

    shaker: int
    emission: BurstOutput | WaveOutput


class ForceTimeline:
    """The timeline of all forces, in seconds since the stream began."""

    def __init__(
        self, shakers_x_m: tuple[float, ...], n_per_v: float, floor: FloorMotion | None = None, harmonics: float = 0.0
    ) -> None:
        self._shakers_x_m = shakers_x_m
        self._n_per_v = n_per_v
        self._floor = floor
        self._harmonics = harmonics
        self._hits: list[HammerHit] = []
        self._emissions: list[_On] = []

    def give_up(self, now_s: float) -> None:
        """Hits that were meant but not yet struck are not."""
        self._hits = [b for b in self._hits if b.start_s <= now_s]

    def strike(self, hits: list[HammerHit]) -> None:
        """Schedule hits."""
        self._hits += hits

    def play_outputs(self, *emissions: BurstOutput | WaveOutput) -> None:
        """Put a burst or a wave on each shaker, the first one's first."""
        self._emissions += [_On(shaker, emission) for shaker, emission in enumerate(emissions)]

    def is_playing(self, now_s: float) -> bool:
        """Whether a burst has still to come to its end, other than one that was cut."""
        return any(e.cut_s is None and e.end_s > now_s for _, e in self._emissions)

    def end_outputs(self, at_s: float) -> None:
        """Bring all shakers to zero at `at_s`."""
        self._emissions = [_On(shaker, e.cut(at_s)) for shaker, e in self._emissions if e.start_s < at_s]

    def forget(self, before_s: float) -> None:
        """Drop what has ended before a time."""
        self._hits = [b for b in self._hits if b.end_s >= before_s]
        self._emissions = [on for on in self._emissions if on.emission.end_s >= before_s]

    def loads_acting(self, first: int, count: int, step_s: float) -> list[BeamLoad]:
        """The loads that act on `count` internal samples from `first`; none where nothing excites."""
        start_s, end_s = first * step_s, (first + count) * step_s
        hits = [b for b in self._hits if b.start_s < end_s and b.end_s > start_s]
        played = [on for on in self._emissions if on.emission.start_s < end_s and on.emission.end_s > start_s]
        shaking = [BeamLoad(0.0, self._floor.acceleration(first, count), 0.0, "base", False)] if self._floor else []
        if not hits and not played:
            return shaking
        times = np.arange(first, first + count, dtype=np.float64) * step_s
        drives = [BeamLoad(hit.x_m, hit.force(times), seen=hit.seen) for hit in hits]
        for shaker, x_m in enumerate(self._shakers_x_m):
            volts = [e.volts(times) for own, e in played if own == shaker]
            if volts:
                drives += self._shaken(shaker, x_m, np.sum(volts, axis=0))
        return drives + shaking

    def _shaken(self, shaker: int, x_m: float, volts: Real) -> list[BeamLoad]:
        drives = [BeamLoad(x_m, volts * self._n_per_v, 1 / self._n_per_v, shaker=shaker)]
        if self._harmonics:
            distorted = self._harmonics * volts * (volts / AMPLIFIER_V + (volts / AMPLIFIER_V) ** 2)
            drives.append(BeamLoad(x_m, distorted * self._n_per_v, shaker=shaker))
        return drives
