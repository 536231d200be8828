"""Curves over frequency that show where modes are, and how many: multivariate MIF and CMIF.

Sources: Williams, Crowley, Vold, "The multivariate mode indicator function in
modal analysis", IMAC 3 (1985); Shih, Tsuei, Allemang, Brown, "Complex mode indication function and its applications to
spatial domain parameter estimation", MSSP 2 (1988).
"""

import numpy as np

from modallab.core.arrays import Real
from modallab.core.frf import Frf
from modallab.frf.estimate import convert_frf


def mmif(frf: Frf) -> Real:
    """Multivariate MIF (inputs, lines), lowest first: as many curves dip at a line as modes are there.

    Eigenvalues of Hr^T Hr f = mu (Hr^T Hr + Hi^T Hi) f, the in-phase share that the best mix of forces leaves.

    Raises:
        DataError: no FRF, or a line at 0 Hz of other than receptance.
    """
    values = np.moveaxis(convert_frf(frf, "receptance").values, -1, 0)
    in_phase = values.real.transpose(0, 2, 1) @ values.real
    quadrature = values.imag.transpose(0, 2, 1) @ values.imag
    total = in_phase + quadrature
    size = np.trace(total, axis1=1, axis2=2)[:, None, None] * np.eye(total.shape[1])
    factor = np.linalg.cholesky(total + 1e-13 * size + np.finfo(float).tiny * np.eye(total.shape[1]))
    half = np.linalg.solve(factor, in_phase)
    whole = np.linalg.solve(factor, half.transpose(0, 2, 1))
    left = np.linalg.eigvalsh((whole + whole.transpose(0, 2, 1)) / 2)
    return np.asarray(np.clip(left, 0, 1).T, np.float64)


def cmif(frf: Frf) -> Real:
    """CMIF (min(outputs, inputs), lines): singular values of the FRF matrix squared, largest first.

    Raises:
        DataError: as for `mmif`.
    """
    values = np.moveaxis(convert_frf(frf, frf.quantity).values, -1, 0)
    return np.asarray(np.linalg.svd(values, compute_uv=False).T ** 2, np.float64)
