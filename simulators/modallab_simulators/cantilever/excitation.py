"""What drives the beam and when: hits struck or meant, bursts on the shaker, a floor that shakes at random."""

from copy import copy
from typing import NamedTuple

import numpy as np

from modallab.core.arrays import Real
from modallab_simulators.cantilever.hammer import HammerHit
from modallab_simulators.cantilever.loads import BeamLoad
from modallab_simulators.cantilever.shaker import BurstOutput, WaveOutput

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
