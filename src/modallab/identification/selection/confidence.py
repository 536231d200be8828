"""How clearly each mode stands above what else could look like one: noise, and what the model leaves unexplained."""

import numpy as np

from modallab.core.arrays import Real
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.selection.prune import MIN_SIGNIFICANCE

MODEL_ERROR_FROM = 1.1
"""Up to this ratio of misfit to pre-trigger noise there is no model error to speak of."""
SHARE = 0.2
"""Of the misfit that is no noise: what a mode explains at least."""


def strength_of_modes(fit: LikelihoodFit) -> Real:
    """(modes,) the largest of a mode's modal constants in units of its sigma."""
    constants, sigma = fit.modal_constants
    return np.max(np.abs(constants) / np.maximum(np.abs(sigma), np.finfo(float).tiny), axis=(1, 2))


def least_strength(fit: LikelihoodFit, misfit_ratio: float) -> float:
    """The strength below which a pole may stand for noise, or for what is wrong with the model.

    A pole of strength q lowers the squared misfit of an output by q^2, in units of the fit's residual. Of these
    `rows` units a share 1 - 1 / r^2 is no noise, where the residual is r times the noise. A pole that explains less
    than a fifth of that may be one of many that stand for one and the same error.

    Args:
        fit: the fit.
        misfit_ratio: r; NaN where it is not known.
    """
    if not misfit_ratio > MODEL_ERROR_FROM:
        return MIN_SIGNIFICANCE
    rows = sum(len(group.residual) for group in fit.point.groups)
    return max(MIN_SIGNIFICANCE, float(np.sqrt(SHARE * rows * (1 - misfit_ratio**-2))))


def confidence_of_strength(strengths: Real, least: float) -> Real:
    """0 (a pole at the limit) to 1 (far above it), per mode: 1 - limit / strength."""
    return np.clip(1 - least / np.maximum(strengths, np.finfo(float).tiny), 0.0, 1.0)
