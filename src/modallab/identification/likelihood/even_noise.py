"""In which quantity the noise of FRFs is even over the lines: that which was measured.

An accelerometer's noise is even in the inertance, and falls with the square of the frequency in the receptance that is
made of it. What a fit leaves shows it, by the likelihood of noise that goes with each power of the frequency.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import DERIVATIVES, FrfQuantity
from modallab.identification.likelihood.fit import LikelihoodFit

WORDS = "The noise is taken as even over the lines in the {quantity}, by what the fit leaves of it."


def quantity_of_even_noise(fit: LikelihoodFit) -> FrfQuantity:
    """The quantity in which a fit of FRFs leaves what is most likely even noise, of each FRF its own.

    Args:
        fit: of FRFs whose lines are not weighted.
    """
    (group,), grid = fit.point.groups, fit.problem.blocks[0].excitation.grid
    square = np.sum(group.residual.reshape(grid.omega.size, 2, -1) ** 2, axis=1)
    square = np.maximum(square, np.finfo(float).tiny)
    costs = {q: _likelihood_cost(square, np.log(grid.omega) * 2 * (DERIVATIVES[q] - grid.p)) for q in DERIVATIVES}
    return min(DERIVATIVES, key=lambda quantity: costs[quantity])


def _likelihood_cost(square: NDArray[np.float64], log_factor: NDArray[np.float64]) -> float:
    """Minus the log likelihood of residuals whose squares (lines, FRFs) are even times a factor."""
    level = log_factor - log_factor.mean()
    return float(len(level) * np.sum(np.log(np.mean(square * np.exp(level)[:, None], axis=0))))
