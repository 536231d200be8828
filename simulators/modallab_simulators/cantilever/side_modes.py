"""Modes that are none of bending: torsion (Blevins, table 8-16), or one of which only the shape's growth is known."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from modallab.core.arrays import Real

POISSON = 0.3


@dataclass(frozen=True, slots=True)
class TorsionBar:
    """A bar clamped at x = 0, behind the interface of its modes; what moves is its angle in rad.

    Attributes:
        length_m: L.
        stiffness_n_m2: G J.
        inertia_kg_m: rho I_p, per length.
    """

    length_m: float
    stiffness_n_m2: float
    inertia_kg_m: float

    @classmethod
    def of(cls, length_m: float, width_m: float, thickness_m: float, modulus_pa: float, density: float) -> "TorsionBar":
        """A flat bar: J = w h^3 (1 / 3 - 0.21 h / w) (Roark, table 10.7), I_p = w h (w^2 + h^2) / 12."""
        shear = modulus_pa / (2 * (1 + POISSON))
        constant = width_m * thickness_m**3 * (1 / 3 - 0.21 * thickness_m / width_m)
        polar = width_m * thickness_m * (width_m**2 + thickness_m**2) / 12
        return cls(length_m, shear * constant, density * polar)

    @property
    def total_mass_kg(self) -> float:
        """Of its turning: the moment of inertia in kg m^2."""
        return self.inertia_kg_m * self.length_m

    def omega(self, count: int) -> Real:
        """Natural frequencies in rad/s, (count,)."""
        speed = sqrt(self.stiffness_n_m2 / self.inertia_kg_m)
        return self._waves(count) * speed

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        return int(np.searchsorted(self.omega(400), omega))

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Angle of the modes, (points, count)."""
        if order:
            raise ValueError("the slope of an angle is not defined")
        angle: Real = np.sin(np.multiply.outer(x_m, self._waves(count)))
        angle *= sqrt(2 / self.total_mass_kg)
        return angle

    def participation(self, count: int) -> Real:
        """Nothing: a base that shifts turns no bar."""
        return np.zeros(count)

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static angle at `x_m` per moment about the bar's axis at `force_x_m`, (points,)."""
        near = np.minimum(x_m, force_x_m, dtype=np.float64)
        return near / self.stiffness_n_m2

    def _waves(self, count: int) -> Real:
        odd = np.arange(1, count + 1, dtype=np.float64) - 0.5
        return odd * (pi / self.length_m)


@dataclass(frozen=True, slots=True)
class SingleMode:
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
            raise ValueError("the slope of a single mode is not defined")
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
