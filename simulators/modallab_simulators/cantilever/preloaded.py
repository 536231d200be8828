"""Modes of the beam under an axial force, which bends with it: the string's stiffness added to the beam's."""

from functools import cached_property

import numpy as np

from modallab.core.arrays import Real
from modallab_simulators.cantilever.attached import SUMMED
from modallab_simulators.cantilever.eigenmodes import eigh
from modallab_simulators.cantilever.modes import Modes
from modallab_simulators.cantilever.ritz import RitzModes

_NODES = 600


class PreloadedModes(RitzModes):
    """A structure under an axial force, behind the interface of its modes.

    Rayleigh-Ritz on the modes without: the force adds the integral of P W_i' W_j' to their stiffness (Blevins, 8.1).

    Args:
        bare: the structure without.
        force_n: P, positive where it pulls.
    """

    def __init__(self, bare: Modes, force_n: float) -> None:
        super().__init__(bare, _NODES)
        self._force = force_n

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static answer at `x_m` to a load at `force_x_m`, (points,)."""
        omega, vectors = self._solved
        to, load = self._bare.shapes(x_m, SUMMED, seen), self._bare.shapes(np.array([force_x_m]), SUMMED, put)[0]
        with_force = (to @ vectors / omega**2) @ (vectors.T @ load)
        without = (to / self._bare.omega(SUMMED) ** 2) @ load
        return self._bare.flexibility(x_m, force_x_m, seen, put) + with_force - without

    @cached_property
    def _solved(self) -> tuple[Real, Real]:
        x_m, weights = self._nodes
        slopes = self._bare.shapes(x_m, SUMMED, 1)
        stiffness = np.diag(self._bare.omega(SUMMED) ** 2) + self._force * slopes.T @ (slopes * weights[:, None])
        values, vectors = eigh(stiffness)
        return np.sqrt(values), vectors
