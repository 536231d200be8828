"""What is believed of a parameter before the test."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import DataError


@dataclass(frozen=True, slots=True)
class Prior:
    """A normal distribution, or a log-normal one for a positive parameter.

    Attributes:
        value: most probable, in SI units.
        sigma: one standard deviation; of `relative` ones that of the logarithm, 0.05 for 5 %.
        relative: whether the parameter is positive with a relative deviation.
        unit: in words.
    """

    value: float
    sigma: float
    relative: bool = False
    unit: str = ""

    def __post_init__(self) -> None:
        """Reject what is no distribution."""
        if not (isfinite(self.value) and isfinite(self.sigma) and self.sigma > 0):
            raise DataError(
                f"a prior of {self.value:g} with deviation {self.sigma:g} is none",
                remedy="give a finite value and a deviation above 0",
            )
        if self.relative and self.value <= 0:
            raise DataError(
                f"a relative deviation about {self.value:g} is none", remedy="give a value above 0, or an absolute one"
            )

    def at(self, u: float | Real) -> Real:
        """Values at u standard deviations from the most probable one."""
        off = self.sigma * np.asarray(u, np.float64)
        return np.asarray(self.value * np.exp(off) if self.relative else self.value + off)
