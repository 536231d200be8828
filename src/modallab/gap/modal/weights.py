"""How a misfit is weighed: each FRF by its own error, and what lies outside the band as known roughly only.

The residual terms of a modal model stand for all modes outside the band. Those are short waves: a sensor or a hit that
is off by a little moves them by a lot, and each test tells them its own way. So each FRF may have its own, within a
share of what they are. That is a covariance between the lines of an FRF, which is taken off here once and for all.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, eq=False, slots=True)
class Weights:
    """Of the lines of every FRF.

    Attributes:
        sigma: (lines, outputs, inputs) what each line may be off by on its own.
        along: (FRFs, 2 lines, terms) unit vectors, real parts before imaginary parts, in which an FRF is known less.
        across: (FRFs, terms, 2 lines) the same.
        less: (FRFs, terms) share of a misfit along each that does not count.
    """

    sigma: Real
    along: Real
    across: Real
    less: Real

    @classmethod
    def of(cls, sigma: Real, shapes: Complex, spread: Real) -> "Weights":
        """Of lines that are off by sigma, and by terms besides.

        Args:
            sigma: (lines, outputs, inputs).
            shapes: (terms, lines) each over the lines.
            spread: (terms, outputs, inputs) deviation of each.
        """
        lines, frfs = sigma.shape[0], sigma[0].size
        one = np.concatenate([shapes.real, shapes.imag], axis=1)
        scaled = np.einsum("tl,tf->flt", one, spread.reshape(len(one), frfs))
        scaled /= np.tile(sigma.reshape(lines, frfs).T, 2)[:, :, None]
        along, size, _ = np.linalg.svd(scaled, full_matrices=False)
        along = np.ascontiguousarray(along)
        across = np.ascontiguousarray(along.transpose(0, 2, 1))
        return cls(sigma, along, across, 1 - 1 / np.sqrt(1 + size**2))

    def weighed(self, misfit: Complex) -> Real:
        """(FRFs 2 lines, any number) of misfits (any number, lines, outputs, inputs), in deviations."""
        n, lines = misfit.shape[:2]
        scaled = (misfit / self.sigma).reshape(n, lines, -1).transpose(2, 1, 0)
        real = np.empty((len(scaled), 2 * lines, n))
        real[:, :lines], real[:, lines:] = scaled.real, scaled.imag
        real -= self.along @ (self.less[:, :, None] * (self.across @ real))
        return real.reshape(-1, n)
