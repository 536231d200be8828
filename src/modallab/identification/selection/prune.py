"""Which refined poles are modes, and which only fitted noise."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.search import MIN_ZETA
from modallab.identification.selection.criteria import mac

MIN_SIGNIFICANCE = 5.0
MAX_ZETA = 0.2
MAX_FREQUENCY_SIGMA = 2e-3
MAX_DAMPING_SIGMA = 0.5
MUCH_WORSE = 3.0
"""Times the sigma of the better known."""
NEAR, NEAR_ALONE = 0.5, 1.0
"""Half-widths: nearer poles may stand on one another; where there is a single FRF, nothing but its course along the
lines says that there are two."""
ALIKE = 0.5
"""MAC of two poles' modal constants, over responses and forces, from which they may be one mode."""


def is_mode(fit: LikelihoodFit, band_hz: tuple[float, float]) -> NDArray[np.bool_]:
    """(modes,) whether a pole stands in the band, is stable, and is known well enough to be called a mode.

    A pole that fits noise has an uncertainty as large as itself: sigma of f above 0.2 %, of zeta above half of zeta, or
    no modal constant that stands above five of its sigmas.
    """
    at, sigma = fit.point.parameters, fit.pole_sigma
    # At the end of the search's range the damping comes out as none: a line, and no resonance.
    stable = (at.zeta > 2 * MIN_ZETA) & (at.zeta < MAX_ZETA)
    known = (sigma[:, 0] < MAX_FREQUENCY_SIGMA * at.omega) & (sigma[:, 1] < MAX_DAMPING_SIGMA * np.abs(at.zeta))
    constants, sigma_of_parts = fit.modal_constants
    seen = np.max(np.abs(constants) / np.maximum(np.abs(sigma_of_parts), 1e-300), axis=(1, 2)) > MIN_SIGNIFICANCE
    good = stable & known & seen
    double, host = _double_poles(fit, constants, good)
    # Beside its double a mode is hardly known; without it, it will be.
    return fit.inside(band_hz) & stable & (good | host) & ~double


def _double_poles(
    fit: LikelihoodFit, constants: NDArray[np.complex128], good: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Poles that stand on a better known one, and those they stand on.

    They are nearer than half a half-width, in a single FRF than a whole one, with shapes that cancel, and much worse
    known or not known at all. One force sees one shape at a frequency. From several, two modes there have modal
    constants that differ. Of two that share one mode neither may be known, so that their constants say nothing; one has
    to stay for it.
    """
    at, sigma = fit.point.parameters, fit.pole_sigma
    likeness = mac(*(constants.reshape(at.omega.size, -1),) * 2)
    alike = (likeness > ALIKE) | (len(fit.input_points) == 1)
    reach = NEAR_ALONE if constants[0].size == 1 else NEAR
    double, host = np.zeros(at.omega.size, bool), np.zeros(at.omega.size, bool)
    order = np.argsort(sigma[:, 0] / at.omega)
    for place, i in enumerate(order):
        for j in order[:place]:
            apart, width = abs(at.omega[i] - at.omega[j]), np.abs(at.zeta[[i, j]] * at.omega[[i, j]])
            worse = sigma[i, 0] > MUCH_WORSE * sigma[j, 0] or not good[i]
            one_mode = apart < reach * width.min() and not (good[i] or good[j])
            if one_mode or (apart < reach * width[0] and worse and alike[i, j]):
                double[i] = host[j] = True
    return double, host & ~double


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
