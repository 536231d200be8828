"""Modes of a structure that differs a little from another one, as sums of the other's modes (Rayleigh-Ritz)."""

from functools import cached_property

from modallab.core.arrays import Real
from modallab.core.quadrature import gauss_legendre
from modallab_simulators.cantilever.attached import SUMMED
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
