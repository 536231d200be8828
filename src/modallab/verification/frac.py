"""Frequency response assurance criterion."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError


def frac(measured: NDArray[np.complex128], model: NDArray[np.complex128]) -> NDArray[np.float64]:
    """FRAC of two FRFs over their last axis: |H^H G|^2 / (H^H H G^H G), 1 where they agree up to a factor, else less.

    Source: Heylen, Lammens, "FRAC: a consistent way of comparing frequency response functions", IDENT'96 (1996).

    Args:
        measured: (..., lines).
        model: (..., lines).

    Raises:
        DataError: shapes that differ, no lines, or NaN.
    """
    if measured.shape != model.shape or measured.ndim < 1 or measured.shape[-1] == 0:
        raise DataError(
            f"FRFs of shapes {measured.shape} and {model.shape} cannot be compared",
            remedy="give both at the same lines",
        )
    if not (np.isfinite(measured).all() and np.isfinite(model).all()):
        raise DataError("an FRF holds NaN or infinite values", remedy="leave its lines out of the comparison")
    cross = np.abs(np.sum(measured.conj() * model, axis=-1)) ** 2
    power = np.sum(np.abs(measured) ** 2, axis=-1) * np.sum(np.abs(model) ** 2, axis=-1)
    return np.divide(cross, power, out=np.zeros_like(cross), where=power > 0)
