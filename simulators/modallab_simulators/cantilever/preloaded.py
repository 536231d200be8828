"""Modes of the beam under an axial force, which bends with it: the string's stiffness added to the beam's."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.core.quadrature import gauss_legendre
from modallab_simulators.cantilever.attached import SUMMED
from modallab_simulators.cantilever.eigenmodes import eigh
from modallab_simulators.cantilever.modes import Modes

Floats = NDArray[np.float64]

_NODES = 600


class PreloadedModes:
    """A structure under an axial force, behind the interface of its modes.

    Rayleigh-Ritz on the modes without: the force adds the integral of P W_i' W_j' to their stiffness (Blevins, 8.1).

    Args:
        bare: the structure without.
        force_n: P, positive where it pulls.
    """

    def __init__(self, bare: Modes, force_n: float) -> None:
        self._bare, self._force = bare, force_n

    @property
    def length_m(self) -> float:
        """Of the beam."""
        return self._bare.length_m

    @property
    def total_mass_kg(self) -> float:
        """Of all that moves."""
        return self._bare.total_mass_kg

    def omega(self, count: int) -> Floats:
        """Natural frequencies in rad/s, (count,)."""
        return self._solved[0][:count]

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        return int(np.searchsorted(self._solved[0], omega))

    def shapes(self, x_m: Floats, count: int, order: int = 0) -> Floats:
        """Displacement or slope of the modes, (points, count)."""
        return self._bare.shapes(x_m, SUMMED, order) @ self._solved[1][:, :count]

    def participation(self, count: int) -> Floats:
        """Integral of mass times shape, in kg^1/2, (count,)."""
        return self._bare.participation(SUMMED) @ self._solved[1][:, :count]

    def flexibility(self, x_m: Floats, force_x_m: float, seen: int = 0, put: int = 0) -> Floats:
        """Static answer at `x_m` to a load at `force_x_m`, (points,)."""
        omega, vectors = self._solved
        to, load = self._bare.shapes(x_m, SUMMED, seen), self._bare.shapes(np.array([force_x_m]), SUMMED, put)[0]
        with_force = (to @ vectors / omega**2) @ (vectors.T @ load)
        without = (to / self._bare.omega(SUMMED) ** 2) @ load
        return self._bare.flexibility(x_m, force_x_m, seen, put) + with_force - without

    @cached_property
    def _solved(self) -> tuple[Floats, Floats]:
        at, weights = gauss_legendre(_NODES)
        half = self.length_m / 2
        slopes = self._bare.shapes(half * (at + 1), SUMMED, 1)
        stiffness = np.diag(self._bare.omega(SUMMED) ** 2) + self._force * slopes.T @ (
            slopes * (weights * half)[:, None]
        )
        values, vectors = eigh(stiffness)
        return np.sqrt(values), vectors
