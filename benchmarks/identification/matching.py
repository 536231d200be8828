"""Which estimate is which true mode: one to one, so that one pole never stands for two close modes."""

import numpy as np
from numpy.typing import NDArray

NEAR = 0.01
"""An estimate within 1 % of a true frequency, and nearer to it than to another, may be that mode."""


def matched(truth_hz: NDArray[np.float64], found_hz: NDArray[np.float64]) -> list[int | None]:
    """For each true mode the index of its estimate, or None; the nearest pairs are taken first.

    Args:
        truth_hz: (modes,)
        found_hz: (estimates,), NaN where there is none.
    """
    away = np.abs(found_hz[None, :] / truth_hz[:, None] - 1) if found_hz.size else np.empty((truth_hz.size, 0))
    apart = np.abs(truth_hz[None, :] / truth_hz[:, None] - 1)
    np.fill_diagonal(apart, np.inf)
    limit = np.minimum(NEAR, apart.min(axis=1, initial=np.inf) / 2)
    away = np.where(away < limit[:, None], away, np.inf)
    pairs: list[int | None] = [None] * truth_hz.size
    while away.size and np.isfinite(away.min()):
        mode, estimate = np.unravel_index(np.argmin(away), away.shape)
        pairs[mode] = int(estimate)
        away[mode], away[:, estimate] = np.inf, np.inf
    return pairs
