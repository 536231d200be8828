"""One mode that is none of bending, of which no more is known than how its shape grows along the beam."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from modallab.core.arrays import Real


@dataclass(frozen=True, slots=True)
class LoneMode:
    """A mode along (x / L)^power, behind the interface of all modes.

    Attributes:
        length_m: L.
        hz: natural frequency.
        kg: mass that swings with the tip.
        power: of its shape.
    """

    length_m: float
    hz: float
    kg: float
    power: float

    @property
    def total_mass_kg(self) -> float:
        """Of what swings."""
        return self.kg

    def omega(self, count: int) -> Real:
        """Natural frequency in rad/s, (count,), of one mode at most."""
        return np.full(min(count, 1), 2 * pi * self.hz)

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        return int(2 * pi * self.hz < omega)

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Displacement of the mode in kg^-1/2, (points, count)."""
        if order:
            raise ValueError("the slope of a lone mode is asked of nobody")
        return self._shape(x_m)[:, None][:, :count]

    def participation(self, count: int) -> Real:
        """Nothing: what swings is not known, so neither is what a base that shakes does to it."""
        return np.zeros(min(count, 1))

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static displacement at `x_m` per force at `force_x_m`, (points,)."""
        return self._shape(x_m) * float(self._shape(np.array([force_x_m]))[0]) / (2 * pi * self.hz) ** 2

    def _shape(self, x_m: Real) -> Real:
        grown: Real = (x_m / self.length_m) ** self.power
        return grown / sqrt(self.kg)
