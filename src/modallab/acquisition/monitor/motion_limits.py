"""Limits of velocity, displacement and stroke, where the channel measures an acceleration or a velocity.

One integration is s / (s^2 + sqrt(2) w s + w^2), two are its square: above the corner w the integral, below it nothing,
so that neither an offset nor its drift adds up. It is causal, goes on from chunk to chunk, and begins with the mean of
the first chunk taken off. Sampled with a hold it reads high, by 1.7 % an integration at a tenth of the rate and by 32 %
at 0.4 of it, and never low above four times the corner by more than 0.4 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np
from scipy.signal import cont2discrete, lfilter

from modallab.bench.protocol import Burst, SampleChunk
from modallab.core.arrays import Real
from modallab.core.errors import SafetyError
from modallab.core.rig import Channel, Limits, Rig
from modallab.core.units import DERIVATIVE, SI_UNIT, Quantity
from modallab.signals.conversion import Conversion

CORNER_HZ = 1.0
CORNER_PART = 0.2
"""The corner lies no higher than this part of the lowest frequency that is driven."""

FORESEEN_FROM = 0.2
"""From this part of the full drive on, what it will be at the full drive is foreseen from what it is."""

REMEDY = "lower the drive level or begin at a higher frequency; earlier blocks are kept"


@dataclass(frozen=True, slots=True)
class MotionLimit:
    """A limit of what a channel does not measure itself.

    Attributes:
        channel: place in the rig.
        what: in words, with the channel's name.
        unit: of the limit.
        integrations: from what it measures to what is limited.
        limit: magnitude.
    """

    channel: int
    what: str
    unit: str
    integrations: int
    limit: float


class MotionWatch:
    """Raises on the first chunk beyond a limit, or in the rise of a burst that will lead beyond it."""

    def __init__(self, limits: Sequence[MotionLimit], si_per_count: Real, rate_hz: float, lowest_hz: float) -> None:
        """Watch `limits` at a rate; `lowest_hz` is the lowest frequency that is driven."""
        self._limits, self._rate_hz = tuple(limits), rate_hz
        self._rows = [limit.channel for limit in limits]
        self._si = si_per_count[self._rows, None]
        self._limit = np.array([limit.limit for limit in limits])
        self.corner_hz = min(CORNER_HZ, CORNER_PART * lowest_hz)
        w = 2 * pi * self.corner_hz
        # The stubs of SciPy know no system of lists.
        discrete: Any = cont2discrete
        numerator, denominator, _ = discrete(([1.0, 0.0], [1.0, sqrt(2) * w, w * w]), 1 / rate_hz, "zoh")
        self._filter = (np.ravel(numerator), np.ravel(denominator))
        self.restart()

    def restart(self) -> None:
        """The stream begins again."""
        self._bias: Real | None = None
        self._state = np.zeros((2, len(self._rows), 2))
        self._burst: tuple[Burst, int] | None = None
        self._rest = np.zeros(len(self._rows))
        self._highest = np.zeros(len(self._rows))

    def begin(self, burst: Burst, start: int) -> None:
        """A burst begins at sample `start`; what moved before it is none of its doing."""
        self._burst = (burst, start)
        self._rest, self._highest = self._highest, np.zeros(len(self._rows))

    def end(self) -> None:
        """The burst has ended."""
        self._burst = None
        self._highest = np.zeros(len(self._rows))

    @property
    def share_of_limit(self) -> float:
        """The largest part of a limit that was taken since the burst began."""
        return float((self._highest / self._limit).max())

    def __call__(self, chunk: SampleChunk) -> None:
        """Look at a chunk.

        Raises:
            SafetyError: names what is, or will be, beyond its limit.
        """
        magnitude = np.abs(self._integrated(chunk.samples[self._rows].astype(np.float64) * self._si))
        peak = magnitude.max(axis=1)
        self._highest = np.maximum(self._highest, peak)
        self._require(peak, "beyond the abort limit")
        if self._burst is None:
            return
        burst, start = self._burst
        times = (np.arange(magnitude.shape[1]) + chunk.first_sample - start) / self._rate_hz
        level = burst.envelope(times)
        rising = (level >= FORESEEN_FROM) & (times < burst.ramp_s)
        if rising.any():
            above = np.maximum(magnitude[:, rising] - 2 * self._rest[:, None], 0) / level[rising]
            self._require(above.max(axis=1), "will exceed the abort limit at the full drive, as predicted")

    def _integrated(self, values: Real) -> Real:
        bias = self._bias if self._bias is not None else values.mean(axis=1, keepdims=True)
        self._bias = bias
        values = values - bias
        found = np.empty_like(values)
        order = np.array([limit.integrations for limit in self._limits])
        for stage in range(2):
            values, self._state[stage] = lfilter(*self._filter, values, axis=1, zi=self._state[stage])
            found[order == stage + 1] = values[order == stage + 1]
        return found

    def _require(self, reached: Real, how: str) -> None:
        over = np.flatnonzero(~(reached <= self._limit))
        if over.size:
            found = ", ".join(
                f"{self._limits[c].what} {reached[c]:.4g} {self._limits[c].unit} (limit {self._limits[c].limit:.4g})"
                for c in over
            )
            raise SafetyError(f"{how}: {found}; the output was brought to 0 V", remedy=REMEDY)


def motion_limits(rig: Rig, limits: Limits) -> tuple[MotionLimit, ...]:
    """What must be integrated to hold a rig's limits; what a channel measures itself is not among it."""
    return tuple(
        MotionLimit(channel.index, f"{what} of {channel.name}", SI_UNIT[quantity], integrations, limit)
        for channel in rig.responses
        for what, quantity, limit in _stated_limit(rig, limits, channel)
        if channel.quantity != "voltage"
        and limit is not None
        and (integrations := DERIVATIVE[channel.quantity] - DERIVATIVE[quantity]) > 0
    )


def motion_watch(
    rig: Rig, limits: Limits, conversion: Conversion, rate_hz: float, lowest_hz: float
) -> MotionWatch | None:
    """The watch for them; None where there are none."""
    found = motion_limits(rig, limits)
    return MotionWatch(found, np.abs(conversion.si_per_count), rate_hz, lowest_hz) if found else None


def _stated_limit(rig: Rig, limits: Limits, channel: Channel) -> tuple[tuple[str, Quantity, float | None], ...]:
    at_shaker = channel.point in rig.shaker_points
    return (
        ("velocity", "velocity", limits.velocity_m_s),
        ("displacement", "displacement", limits.displacement_m),
        ("stroke", "displacement", limits.stroke_m if at_shaker else None),
    )
