"""What an error of a model's stiffness and mass does to its modes.

Between the modes of a model such an error is a random symmetric matrix, the same share of every mode (Soize,
Probabilistic Engineering Mechanics 15 (2000), 277). It moves each frequency. It mixes each shape with the others, the
more the nearer their frequencies are (Fox, Kapoor, AIAA Journal 6 (1968), 2426). So errors at the points of a shape go
together.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real

NEAREST = 1e-3
"""Relative difference of two frequencies below which their modes mix as if they differed by this."""


def model_error_covariance(frequency_hz: Real, shapes: Real, places: NDArray[np.int64]) -> Real:
    """Covariance of errors of a model's modes, of such a size that frequencies have unit relative variance.

    Args:
        frequency_hz: (all modes,) of the model, Hz.
        shapes: (all modes, freedoms) at unit modal mass, kg^-1/2.
        places: (modes,) which of them were measured.

    Returns:
        (modes + modes * freedoms, the same) of logarithms of the frequencies measured, then of their shapes.
    """
    count, modes = frequency_hz.size, len(places)
    square, apart = frequency_hz**2, _squares_apart(frequency_hz)
    rows = np.arange(modes)
    mixing = np.zeros((2, modes, count, count, count))
    for r, own in zip(rows, places, strict=True):
        for q in range(count):
            share = np.array([np.sqrt(square[own] * square[q]), -square[own]]) / apart[own, q]
            # One error is shared by both modes that it couples.
            mixing[:, r, q, min(own, q), max(own, q)] = share
        mixing[:, r, own, own, own] = 0.0, -np.sqrt(0.5)
    moved = np.zeros((2, modes, count, count))
    moved[:, rows, places, places] = np.sqrt(0.5) * np.array([[1.0], [-1.0]])
    at_points = np.einsum("erqij,qf->rfeij", mixing, shapes).reshape(shapes.shape[1] * modes, -1)
    factor = np.concatenate([moved.swapaxes(0, 1).reshape(modes, -1), at_points])
    return np.asarray(factor @ factor.T, np.float64)


def _squares_apart(frequency_hz: Real) -> Real:
    """(modes, modes) differences of squared frequencies, none nearer to 0 than `NEAREST` makes it."""
    square = frequency_hz**2
    apart = square[:, None] - square
    least = 2 * NEAREST * frequency_hz[:, None] * frequency_hz
    return np.copysign(np.maximum(np.abs(apart), least), apart)
