"""Which mode of one model is which of another, by frequency."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

SAME_MODE = 0.04
"""Two frequencies this near, relative, and nearest to one another, are taken for the same mode."""


def nearest_partners(
    here: Sequence[float] | NDArray[np.float64],
    there: Sequence[float] | NDArray[np.float64],
    within: float = SAME_MODE,
) -> list[int | None]:
    """For each frequency the place of its partner: nearest to one another and not further than `within`, relative."""
    a, b = np.asarray(here, dtype=np.float64), np.asarray(there, dtype=np.float64)
    if not a.size or not b.size:
        return [None] * a.size
    gap = np.abs(a[:, None] - b)
    forth, back = gap.argmin(1), gap.argmin(0)
    return [int(j) if back[j] == i and gap[i, j] <= within * a[i] else None for i, j in enumerate(forth)]
