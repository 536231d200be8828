"""How much each line of measured FRFs counts: by its variance, as coherence and averages say it.

Source: Bendat and Piersol, "Random Data", 4th ed. (2010), table 9.6: of an H1 of n averages with coherence c the
relative variance of the complex number is (1 - c) / (n c).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.frf import Frf

Real = NDArray[np.float64]

NEIGHBOURS = 5
"""Lines over whose median a variance is at least taken: by chance a coherence of few averages is near 1."""
LEAST = 1e-6
"""Below this 1 - coherence is rounding."""
RANGE = 1e-4
"""A line counts for at least this share of the best known one."""


def line_weights(frf: Frf) -> Real | None:
    """(lines,) by which residuals are multiplied, of mean square 1; None where nothing is known of the lines.

    All FRFs share the model's columns, and so the weights: a line's are those of the geometric mean of its variances,
    each relative to its own FRF's. How large the noise of each FRF is, its residuals say.

    Args:
        frf: with `variance`, or with `coherence`.
    """
    variance = frf.variance if frf.variance is not None else _of_coherence(frf)
    if variance is None or not np.isfinite(variance).all():
        return None
    variance = np.maximum(variance, ndimage.median_filter(variance, size=(1, 1, NEIGHBOURS), mode="nearest"))
    relative = np.log(np.maximum(variance, np.finfo(float).tiny))
    mean = np.mean(relative - np.median(relative, axis=-1, keepdims=True), axis=(0, 1))
    weight = np.exp(-mean / 2)
    weight = np.maximum(weight, np.sqrt(RANGE) * weight.max())
    return np.asarray(weight / np.sqrt(np.mean(weight**2)), np.float64)


def _of_coherence(frf: Frf) -> NDArray[Any] | None:
    coherence = frf.coherence
    if coherence is None or np.all(coherence > 1 - LEAST):
        # Of one average it is 1 by construction.
        return None
    averages = np.array(frf.averages or (1,) * frf.values.shape[1], dtype=np.float64)[None, :, None]
    known = np.clip(coherence, LEAST, 1 - LEAST)
    return np.abs(frf.values) ** 2 * (1 - known) / (averages * known)
