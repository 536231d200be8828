"""What arrays hold, as types."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]
Complex128 = NDArray[np.complex128]


@lru_cache(maxsize=32)
def gauss_legendre(count: int) -> tuple[Real, Real]:
    """(count,) nodes on -1 to 1 and (count,) weights that integrate polynomials up to order 2 count - 1 exactly.

    Both are read-only. NumPy solves an eigenvalue problem for them each time, which for some hundred nodes takes longer
    than what is integrated.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights
