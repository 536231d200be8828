"""Eigenvalues and eigenvectors of a structure's matrices."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def eigh(stiffness: Floats, mass: Floats | None = None) -> tuple[Floats, Floats]:
    """(n,) ascending eigenvalues and (n, n) eigenvectors, of unit modal mass, of (n, n) symmetric matrices.

    Without a mass matrix it is that of unity.
    """
    # Imported here: a plain beam has its modes in closed form, and its process begins in three quarters of the time.
    from scipy import linalg

    values, vectors = linalg.eigh(stiffness, mass)
    return np.asarray(values, np.float64), np.asarray(vectors, np.float64)
