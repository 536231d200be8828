"""Modes of a structure that differs a little from another one, as sums of the other's modes (Rayleigh-Ritz).

It differs by how its slices turn and what they weigh, or by an axial force.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from modallab.core.arrays import Real
from modallab.core.quadrature import gauss_legendre
from modallab_simulators.cantilever.attached import SUMMED
from modallab_simulators.cantilever.eigenmodes import eigh
from modallab_simulators.cantilever.modes import Modes, SolvedModes


class RitzModes(SolvedModes):
    """Sums of a bare structure's modes, behind the interface of modes.

    Args:
        bare: the structure without what is added.
        nodes: at so many places along the beam what is added is integrated.
    """

    def __init__(self, bare: Modes, nodes: int) -> None:
        super().__init__(bare)
        self._count = nodes

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Displacement or slope of the modes, (points, count)."""
        return self._bare.shapes(x_m, SUMMED, order) @ self._solved[1][:, :count]

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,)."""
        return self._bare.participation(SUMMED) @ self._solved[1][:, :count]

    @cached_property
    def _nodes(self) -> tuple[Real, Real]:
        """Places along the beam in m, and their weights in an integral, (nodes,)."""
        at, weights = gauss_legendre(self._count)
        half = self.length_m / 2
        return half * (at + 1), weights * half


_NODES = 320


class RotaryModes(RitzModes):
    """A structure with rotary inertia, behind the interface of its modes.

    Rayleigh-Ritz on the modes without: slices add the integral of rho I W_i' W_j' to their mass (Rayleigh's beam:
    Han, Benaroya and Wei, Dynamics of transversely vibrating beams, Journal of Sound and Vibration 225, 1999).

    Args:
        bare: the structure without.
        inertia_kg_m: rho I, moment of inertia of the slices per length.
        waves: (k, a): rho A a cos(k pi x / L) that each slice weighs more, kg/m.
    """

    def __init__(self, bare: Modes, inertia_kg_m: float, waves: Sequence[tuple[int, float]] = ()) -> None:
        super().__init__(bare, _NODES)
        self._inertia, self._waves = inertia_kg_m, tuple(waves)

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,); a shift turns no slice."""
        x_m, weights = self._nodes
        heavier = (self._heavier(x_m) * weights) @ self._bare.shapes(x_m, SUMMED)
        return (self._bare.participation(SUMMED) + heavier) @ self._solved[1][:, :count]

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static answer at `x_m` to a load at `force_x_m`: slices at rest have no inertia, (points,)."""
        return self._bare.flexibility(x_m, force_x_m, seen, put)

    def _heavier(self, x_m: Real) -> Real:
        terms = [a * np.cos(k * np.pi * x_m / self.length_m) for k, a in self._waves]
        return np.sum([np.zeros_like(x_m), *terms], axis=0)

    @cached_property
    def _solved(self) -> tuple[Real, Real]:
        x_m, weights = self._nodes
        slopes = self._bare.shapes(x_m, SUMMED, 1) * np.sqrt(weights)[:, None]
        mass = np.eye(SUMMED) + self._inertia * slopes.T @ slopes
        if self._waves:
            shapes = self._bare.shapes(x_m, SUMMED)
            mass += shapes.T @ (shapes * (self._heavier(x_m) * weights)[:, None])
        # By 1 / omega^2 the lowest mode is exact to the last digit, and with it what modes answer statically.
        period = 1 / self._bare.omega(SUMMED)
        values, vectors = eigh(mass * np.outer(period, period))
        omega = values[::-1] ** -0.5
        return omega, period[:, None] * vectors[:, ::-1] * omega


_PRELOADED_NODES = 600


class PreloadedModes(RitzModes):
    """A structure under an axial force, behind the interface of its modes.

    Rayleigh-Ritz on the modes without: the force adds the integral of P W_i' W_j' to their stiffness (Blevins, 8.1).

    Args:
        bare: the structure without.
        force_n: P, positive where it pulls.
    """

    def __init__(self, bare: Modes, force_n: float) -> None:
        super().__init__(bare, _PRELOADED_NODES)
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
