"""Orthonormal columns of a tall matrix."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import IdentificationError

FAR = 0.1
"""After one pass of Cholesky's the columns must be this near to orthonormal; then the second leaves rounding alone."""


def qr_decomposition(tall: Real) -> tuple[Real, Real]:
    """Q (rows, columns) with orthonormal columns and R upper triangular with Q R the matrix given.

    By the Gram matrix's Cholesky factor, twice: three times as fast as Householder's reflections where rows are many,
    and as orthonormal. Columns that hardly differ are left to the reflections.
    Source: Yamamoto, Nakatsukasa, Yanagisawa, Fukaya, "Roundoff error analysis of the CholeskyQR2 algorithm", ETNA 44
    (2015).

    Args:
        tall: (rows, columns) of about unit length, rows at least as many.

    Raises:
        IdentificationError: fewer rows than columns, or values that are not finite.
    """
    if tall.ndim != 2 or not 0 < tall.shape[1] <= tall.shape[0] or not np.isfinite(tall).all():
        raise IdentificationError(
            f"columns of shape {tall.shape} cannot be distinguished, or are not finite",
            remedy="narrow the band to where the force has content, or ask for fewer modes",
        )
    try:
        first = np.linalg.cholesky(tall.T @ tall).T
        q = tall @ np.linalg.inv(first)
        gram = q.T @ q
        if not np.abs(gram - np.eye(len(gram))).max() < FAR:
            return _qr_by_reflections(tall)
        second = np.linalg.cholesky(gram).T
    except np.linalg.LinAlgError:
        return _qr_by_reflections(tall)
    return q @ np.linalg.inv(second), second @ first


def _qr_by_reflections(tall: Real) -> tuple[Real, Real]:
    q, r = np.linalg.qr(tall)
    return q, r


def real_rows(values: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Complex (..., lines) to real (2 lines, ...), the same least-squares problem in real numbers.

    Each line's real part stands above its imaginary part, as they lie in memory: hundreds of FRFs are not copied.
    """
    lies = values.dtype == np.complex128 and values.strides[-1] == values.itemsize
    return np.moveaxis((values if lies else np.ascontiguousarray(values, np.complex128)).view(np.float64), -1, 0)


def stack_lines(values: NDArray[np.complex128]) -> NDArray[np.float64]:
    """The same of complex (lines, ...), where the lines come first: (2 lines, ...)."""
    return np.stack([values.real, values.imag], axis=1).reshape(-1, *values.shape[1:])


def complex_lines(rows: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Real (2 lines, ...) back to complex (..., lines)."""
    return np.ascontiguousarray(np.moveaxis(rows, 0, -1)).view(np.complex128)
