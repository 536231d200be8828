"""Noise of measured FRFs: as their repeats say, else as the lines differ from their neighbours."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.frf import Frf

Real = NDArray[np.float64]

THIRD = 20.0
"""Sum of squares of the third difference's coefficients 1, 3, 3, 1: its variance over that of a line."""
NEIGHBOURS = 31
"""Lines over which the median is taken: more than a resonance is wide, whose lines differ for another reason."""
LOG2 = float(np.log(2.0))
"""Median over mean of the square of a complex normal number."""


def variance_of(frf: Frf) -> Real:
    """(outputs, inputs, lines) variance of the complex FRFs."""
    if frf.variance is not None and np.all(np.isfinite(frf.variance)):
        return frf.variance
    if frf.frequency_hz.size < NEIGHBOURS:
        return np.zeros(frf.values.shape)
    third = np.diff(frf.values, 3, axis=-1)
    power = np.abs(np.concatenate([third[..., :1], third, third[..., -2:]], axis=-1)) ** 2 / THIRD
    size = (1,) * (power.ndim - 1) + (NEIGHBOURS,)
    return ndimage.median_filter(power, size=size, mode="nearest") / LOG2


def with_noise(frf: Frf, variance: Real, rng: np.random.Generator) -> Frf:
    """The same with noise drawn anew."""
    drawn = rng.standard_normal((2, *frf.values.shape))
    return replace(frf, values=frf.values + np.sqrt(variance / 2) * (drawn[0] + 1j * drawn[1]))
