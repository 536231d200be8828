"""How much each line of measured FRFs counts: by its variance, as coherence and averages say it."""

import numpy as np
from scipy import ndimage

from modallab.core.arrays import Real
from modallab.core.frf import Frf
from modallab.frf.line_noise import variance_by_coherence

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
