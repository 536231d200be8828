"""Noise of measured FRFs line by line: as repeats say it, else as the lines differ from their neighbours.

Source: Bendat and Piersol, "Random Data", 4th ed. (2010), table 9.6: of an H1 of n averages with coherence c the
relative variance of the complex number is (1 - c) / (n c).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.arrays import Real
from modallab.core.frf import Frf

LEAST = 1e-6
"""Below this 1 - coherence is rounding."""
THIRD = 20.0
"""Sum of squares of the third difference's coefficients 1, 3, 3, 1: its variance over that of a line."""
NEIGHBOURS = 31
"""Lines over which the median is taken: more than a resonance is wide, whose lines differ for another reason."""
LOG2 = float(np.log(2.0))
"""Median over mean of the square of a complex normal number."""


def variance_of(frf: Frf) -> Real:
    """(outputs, inputs, lines) variance of the complex FRFs."""
    stated = frf.variance if frf.variance is not None else variance_by_coherence(frf)
    if stated is not None and np.all(np.isfinite(stated)):
        return np.asarray(stated, np.float64)
    if frf.frequency_hz.size < NEIGHBOURS:
        return np.zeros(frf.values.shape)
    third = np.diff(frf.values, 3, axis=-1)
    power = np.abs(np.concatenate([third[..., :1], third, third[..., -2:]], axis=-1)) ** 2 / THIRD
    size = (1,) * (power.ndim - 1) + (NEIGHBOURS,)
    return ndimage.median_filter(power, size=size, mode="nearest") / LOG2


def variance_by_coherence(frf: Frf) -> NDArray[Any] | None:
    """(outputs, inputs, lines) as coherence and averages say it; None without them."""
    coherence = frf.coherence
    if coherence is None or np.all(coherence > 1 - LEAST):
        # Of one average it is 1 by construction.
        return None
    averages = np.array(frf.averages or (1,) * frf.values.shape[1], dtype=np.float64)[None, :, None]
    known = np.clip(coherence, LEAST, 1 - LEAST)
    return np.abs(frf.values) ** 2 * (1 - known) / (averages * known)
