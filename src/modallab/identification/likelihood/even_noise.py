"""In which quantity the noise of FRFs is even over the lines: that which was measured.

An accelerometer's noise is even in the inertance, and falls with the square of the frequency in the receptance that is
made of it. What a fit leaves shows it, by the likelihood of noise that goes with each power of the frequency.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.arrays import Real
from modallab.core.frf import DERIVATIVES, Frf, FrfQuantity
from modallab.frf.line_noise import variance_by_coherence
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


NEIGHBOURS = 5
"""Lines over whose median a variance is at least taken: by chance a coherence of few averages is near 1."""
RANGE = 1e-4
"""A line counts for at least this share of the best known one."""


def line_weights(frf: Frf) -> Real | None:
    """(lines,) by which residuals are multiplied, of mean square 1; None where nothing is known of the lines.

    All FRFs share the model's columns, and so the weights: a line's are those of the geometric mean of its variances,
    each relative to its own FRF's. How large the noise of each FRF is, its residuals say.

    Args:
        frf: with `variance`, or with `coherence`.
    """
    variance = frf.variance if frf.variance is not None else variance_by_coherence(frf)
    if variance is None or not np.isfinite(variance).all():
        return None
    variance = np.maximum(variance, ndimage.median_filter(variance, size=(1, 1, NEIGHBOURS), mode="nearest"))
    relative = np.log(np.maximum(variance, np.finfo(float).tiny))
    mean = np.mean(relative - np.median(relative, axis=-1, keepdims=True), axis=(0, 1))
    weight = np.exp(-mean / 2)
    weight = np.maximum(weight, np.sqrt(RANGE) * weight.max())
    return np.asarray(weight / np.sqrt(np.mean(weight**2)), np.float64)
