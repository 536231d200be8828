"""The algebra of state-space realizations: the block Hankel matrix of a series, and the poles of its state matrix.

Two use it on different data: the estimator ERA on impulse responses of FRFs, whose inputs are known, and the diagnosis
of a gap on the decays after hits, whose inputs are not.
Source: Juang and Pappa, "An eigensystem realization algorithm for modal parameter identification and model reduction",
J. Guidance 8 (1985), 620.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def block_hankel(series: NDArray[np.float64], rows: int, columns: int, first: int = 0) -> NDArray[np.float64]:
    """Block (i, j) is the series at lag `first` + i + j: (rows * outputs, columns * inputs).

    Args:
        series: (outputs, inputs, lags), of at least `first` + `rows` + `columns` - 1 lags.
        rows: number of block rows.
        columns: number of block columns.
        first: lag of the first block.
    """
    lag = np.arange(rows)[:, None] + np.arange(columns)[None, :] + first
    n_out, n_in, _ = series.shape
    return series[..., lag].transpose(2, 0, 3, 1).reshape(rows * n_out, columns * n_in)


def state_poles(state: NDArray[np.floating[Any]], dt_s: float) -> NDArray[np.complex128]:
    """Poles log(z) / dt in rad/s of a state matrix, by its eigenvalues z; those that are not finite are left out."""
    z = np.linalg.eigvals(state).astype(np.complex128)
    with np.errstate(divide="ignore"):
        poles = np.log(z) / dt_s
    return np.asarray(poles[np.isfinite(poles)], np.complex128)
