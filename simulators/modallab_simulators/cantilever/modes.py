"""What every set of undamped modes can be asked, whatever the structure behind it."""

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Protocol

import numpy as np

from modallab.core.arrays import Real


class Modes(Protocol):
    """Modes at unit modal mass, ascending, and the statics they add up to. `count` may not exceed `limit`."""

    @property
    def length_m(self) -> float:
        """Of the beam."""
        ...

    @property
    def total_mass_kg(self) -> float:
        """Of all that moves."""
        ...

    def omega(self, count: int) -> Real:
        """Natural frequencies in rad/s, (count,)."""
        ...

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        ...

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Displacement (order 0) or slope (1) of the modes in kg^-1/2, (points, count)."""
        ...

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,)."""
        ...

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static displacement (seen = 0) or slope (1) at `x_m` per force (put = 0) or moment (1), (points,)."""
        ...


class SolvedModes(ABC):
    """Modes of a structure that differs from a bare one, by an eigenvalue problem of its own."""

    def __init__(self, bare: Modes) -> None:
        self._bare = bare

    @property
    def length_m(self) -> float:
        """Of the beam."""
        return self._bare.length_m

    @property
    def total_mass_kg(self) -> float:
        """Of all that moves."""
        return self._bare.total_mass_kg

    def omega(self, count: int) -> Real:
        """Natural frequencies in rad/s, (count,)."""
        return self._solved[0][:count]

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        return int(np.searchsorted(self._solved[0], omega))

    @cached_property
    @abstractmethod
    def _solved(self) -> tuple[Real, Real]:
        """Natural frequencies in rad/s, (modes,), and each mode as a sum of the bare ones, (terms, modes)."""
