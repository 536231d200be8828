"""An effect with its numbers free, as coordinates for a fit."""

from dataclasses import dataclass, replace
from math import log
from typing import Literal

import numpy as np

from modallab.core.arrays import Real
from modallab.core.effect import NO_PLACE, AlongBeam, Place
from modallab.core.effects import Effect
from modallab.twin.elements import ELEMENTS

Transform = Literal["log", "plain", "share"]


NEAR_AN_END = 0.28
"""Natural logarithm from an end of a number's range where it goes on more slowly."""
FARTHEST = 1000.0
"""Times that room which an end is away, as a coordinate."""
SMALLEST = 1e-6
"""Smallest share of a signature that a number is asked for: none at all may have no number."""


@dataclass(frozen=True, slots=True)
class FreeNumber:
    """One free number of an effect.

    Attributes:
        name: the parameter; "x" for the place along the beam.
        transform: log (positive), plain (either sign, in `scale`), share (0 to 1).
        starts: values worth a first look, SI.
        scale: unit of a plain number.
        low: smallest value it may take.
        high: largest.
        none: the number at which there is no effect.
        power: with which a small effect's signature grows with the number's distance from `none`; negative where a
            large number is a small effect, as of the stiffness of a clamp; 0 for a number that is no size.
    """

    name: str
    transform: Transform
    starts: tuple[float, ...]
    scale: float = 1.0
    low: float = -np.inf
    high: float = np.inf
    none: float = 0.0
    power: float = 1.0

    def value(self, u: float) -> float:
        """The number at coordinate u, held within its range."""
        if self.transform == "log":
            free = float(np.exp(np.clip(self._bounded_log(u), -60, 60)))
        elif self.transform == "share":
            free = float(1 / (1 + np.exp(-np.clip(u, -30, 30))))
        else:
            free = u * self.scale
        return min(max(free, self.low), self.high)

    def with_signature(self, value: float, share: float) -> float:
        """The number whose signature is this share, 0 to 1, of that of `value`, to first order in a small effect."""
        if not self.power:
            return value
        origin = self.none if self.power > 0 else 0.0
        return origin + (value - origin) * max(share, SMALLEST) ** (1 / self.power)

    @property
    def weakest_starts(self) -> list[int]:
        """Which starts have the smallest signature: of a number of either sign one of each."""
        if self.power < 0:
            return [int(np.argmax(self.starts))]
        away = np.array(self.starts) - self.none
        sides = (np.flatnonzero(away < 0), np.flatnonzero(away > 0))
        return [int(side[np.argmin(np.abs(away[side]))]) for side in sides if side.size]

    def coordinate(self, value: float) -> float:
        """The coordinate of a number; of a logarithm's zero, that of the smallest number there is."""
        if self.transform == "log":
            return self._coordinate_of_log(float(np.log(max(value, np.finfo(float).tiny))))
        if self.transform == "share":
            return float(np.log(value / (1 - value)))
        return value / self.scale

    @property
    def _ends(self) -> tuple[float, float, float]:
        """Between which logarithms a number runs freely, and how far its range goes on; no room where it has no two
        ends."""
        if not 0 < self.low < self.high < np.inf:
            return -np.inf, np.inf, 0.0
        low, high = log(self.low), log(self.high)
        room = min(NEAR_AN_END, (high - low) / 4)
        return low + room, high - room, room

    def _bounded_log(self, u: float) -> float:
        """The logarithm at coordinate u: ever slower towards an end, so that a fit that ran there finds back."""
        low, high, room = self._ends
        past = max(u - high, low - u)
        if past <= 0 or not room:
            return u
        least = room * past / (room + past)
        return high + least if u > high else low - least

    def _coordinate_of_log(self, logarithm: float) -> float:
        """The coordinate at which the logarithm is this."""
        low, high, room = self._ends
        past = max(logarithm - high, low - logarithm)
        if past <= 0 or not room:
            return logarithm
        most = room * past / max(room - past, room / FARTHEST)
        return high + most if logarithm > high else low - most


@dataclass(frozen=True, slots=True)
class CandidateEffect:
    """An effect at a place, its numbers free.

    Attributes:
        effect: its name.
        slots: its free numbers.
        place: where it is; none where its place along the beam is a free number.
        fixed: parameters that are not free.
    """

    effect: str
    slots: tuple[FreeNumber, ...]
    place: Place = NO_PLACE
    fixed: tuple[tuple[str, float], ...] = ()

    def effect_at(self, u: Real) -> Effect:
        """The effect at coordinates u."""
        values = {s.name: s.value(float(v)) for s, v in zip(self.slots, u, strict=True)}
        place = AlongBeam(x=min(max(values.pop("x"), 0.5 / ELEMENTS), 1.0)) if "x" in values else self.place
        return Effect(effect=self.effect, parameters={**dict(self.fixed), **values}, place=place)

    def with_signature(self, u: Real, share: float) -> Real:
        """Coordinates (numbers,) of the effect whose signature is this share of that at u, to first order.

        Only an effect of one size has such numbers, see `size`.
        """
        return np.array(
            [s.coordinate(s.with_signature(s.value(float(v)), share)) for s, v in zip(self.slots, u, strict=True)]
        )

    @property
    def size(self) -> int | None:
        """Which number says how large it is; None where there is none, or where there are several."""
        sizes = [k for k, s in enumerate(self.slots) if s.power]
        return sizes[0] if len(sizes) == 1 else None

    def with_fixed_place(self, x: float) -> "CandidateEffect":
        """The same, but that its place along the beam, as a share of the length, is not free."""
        slots = tuple(s for s in self.slots if s.name != "x")
        return replace(self, slots=slots, place=AlongBeam(x=x))


def spread_logarithmically(low: float, high: float, count: int) -> tuple[float, ...]:
    """So many values, even on logarithms."""
    return tuple(float(v) for v in np.geomspace(low, high, count))


def values_of_both_signs(low: float, high: float, count: int) -> tuple[float, ...]:
    """So many values of either sign, their magnitudes even on logarithms."""
    values = spread_logarithmically(low, high, count)
    return (*(-v for v in reversed(values)), *values)


def along_beam() -> FreeNumber:
    """The place along the beam, as a share of its length."""
    return FreeNumber("x", "plain", tuple(float(v) for v in np.linspace(0.1, 0.98, 12)), low=0.0, high=1.0, power=0.0)
