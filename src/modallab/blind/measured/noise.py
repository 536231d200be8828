"""Noise of measured FRFs drawn anew."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import Frf

Real = NDArray[np.float64]


def with_noise(frf: Frf, variance: Real, rng: np.random.Generator) -> Frf:
    """The same with noise drawn anew."""
    drawn = rng.standard_normal((2, *frf.values.shape))
    return replace(frf, values=frf.values + np.sqrt(variance / 2) * (drawn[0] + 1j * drawn[1]))
