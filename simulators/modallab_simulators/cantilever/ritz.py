"""Modes of a structure that differs a little from another one, as sums of the other's modes (Rayleigh-Ritz)."""

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.core.quadrature import gauss_legendre
from modallab_simulators.cantilever.attached import SUMMED
from modallab_simulators.cantilever.modes import Modes

Floats = NDArray[np.float64]


class RitzModes(ABC):
    """Sums of a bare structure's modes, behind the interface of modes.

    Args:
        bare: the structure without what is added.
        nodes: at so many places along the beam what is added is integrated.
    """

    def __init__(self, bare: Modes, nodes: int) -> None:
        self._bare, self._count = bare, nodes

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

    @cached_property
    def _nodes(self) -> tuple[Floats, Floats]:
        """Places along the beam in m, and their weights in an integral, (nodes,)."""
        at, weights = gauss_legendre(self._count)
        half = self.length_m / 2
        return half * (at + 1), weights * half

    @cached_property
    @abstractmethod
    def _solved(self) -> tuple[Floats, Floats]:
        """Natural frequencies in rad/s, (SUMMED,), and each mode's share of the bare ones, (SUMMED, SUMMED)."""
