"""Where along a row of values the local_minima are."""

from collections.abc import Sequence

import numpy as np


def local_minima(values: Sequence[float]) -> list[int]:
    """Places of the values that are no higher than those beside them, in their order."""
    wide = np.array([np.inf, *values, np.inf])
    return np.flatnonzero((wide[1:-1] <= wide[:-2]) & (wide[1:-1] <= wide[2:])).tolist()
