"""Eigenvalues and eigenvectors of a structure's matrices."""

import numpy as np

from modallab.core.arrays import Real


def eigh(stiffness: Real, mass: Real | None = None) -> tuple[Real, Real]:
    """(n,) ascending eigenvalues and (n, n) eigenvectors, of unit modal mass, of (n, n) symmetric matrices.

    Without a mass matrix it is that of unity. With one, K v = omega^2 M v becomes a standard problem by M = L L^T
    (Golub and Van Loan, Matrix Computations, 8.7). SciPy has that too, but to import it takes every bench's process a
    quarter of the time in which it begins.
    """
    if mass is None:
        values, vectors = np.linalg.eigh(stiffness)
        return values, vectors
    lower = np.linalg.cholesky(mass)
    half = np.linalg.solve(lower, stiffness)
    standard = np.linalg.solve(lower, half.T)
    values, vectors = np.linalg.eigh((standard + standard.T) / 2)
    return values, np.asarray(np.linalg.solve(lower.T, vectors), dtype=np.float64)
