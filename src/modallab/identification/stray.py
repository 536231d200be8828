"""Weak poles that stand for an error of the model, told by their phases.

Where the fit leaves over more than noise, a pole may be spent on what is wrong: a clock, a nonlinearity, a channel that
lags. Nothing makes the points of such a pole move in step. Those of a mode do, however weak it is, if those of the
strong modes of the same structure do.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.identification.confidence import MODEL_ERROR_FROM
from modallab.identification.criteria import mpd
from modallab.identification.fit import Fit, modal_constants

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]

WEAK = 1.5
"""Strength of a weak pole, in units of the least: it explains little more than what is left over everywhere."""
STRONG = 4.0
OUT_OF_STEP_RAD = 0.1
"""Mean phase deviation beyond its noise from which the points of a weak pole are out of step."""
IN_STEP_RAD = 0.03
"""The strong modes' median, up to which the structure's damping is as good as proportional."""
SIGMAS = 3.0
LEAST_OUTPUTS = 3


def stray(fit: Fit, strengths: Real, least: float, misfit_ratio: float) -> NDArray[np.bool_]:
    """(poles,) weak and out of step, in a fit that leaves over more than noise, of a structure that moves in step.

    Args:
        fit: a refined fit.
        strengths: (poles,) as from `strength`.
        least: as from `least_strength`.
        misfit_ratio: how many times the noise the fit leaves over; NaN where it is not known.
    """
    if not misfit_ratio > MODEL_ERROR_FROM:
        return np.zeros(strengths.size, bool)
    return out_of_step(*modal_constants(fit), strengths, least)


def out_of_step(constants: Complex, sigma: Real, strengths: Real, least: float) -> NDArray[np.bool_]:
    """(modes,) weak ones whose points stand off one phase, where those of the strong ones do not.

    Args:
        constants: (modes, outputs, inputs) kg^-1.
        sigma: (modes, outputs, inputs) of the complex numbers.
        strengths: (modes,) as from `strength`.
        least: as from `least_strength`.
    """
    strong = strengths > STRONG * least
    if constants.shape[1] < LEAST_OUTPUTS or not np.any(strong):
        return np.zeros(strengths.size, bool)
    loudest = np.argmax(np.sum(np.abs(constants), axis=1), axis=1)
    place = np.arange(strengths.size)
    columns, noise = constants[place, :, loudest], sigma[place, :, loudest]
    size = np.sum(np.abs(columns), axis=1)
    silent = size == 0
    deviation = np.where(silent, 0.0, mpd(np.where(silent[:, None], 1.0, columns)))
    # |A| dphi = sigma / sqrt(2) at each point; the mean of absolute values of a normal number is sqrt(2 / pi) of it.
    by_noise = np.sum(noise, axis=1) / np.where(silent, 1.0, size) / np.sqrt(np.pi)
    if np.median(deviation[strong]) > IN_STEP_RAD:
        return np.zeros(strengths.size, bool)
    return (strengths < WEAK * least) & (deviation - SIGMAS * by_noise > OUT_OF_STEP_RAD)
