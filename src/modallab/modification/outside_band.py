"""What modes outside the band add at pairs that were not measured.

The few modes next to the band make most of it, and whatever they add at two points is the product of their shapes
there. So the driven columns tell the others: R_jk = R_jd (R_dd)^-1 R_dk, the Nystroem form of a matrix of low rank
(Halko, Martinsson, Tropp, SIAM Review 53 (2011), section 5).
"""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Real

SIGNIFICANT = 0.1
"""Of the largest eigenvalue among the driven points: smaller ones are noise, and their inverse would be as well."""


def completed(residual: Real, rows: Sequence[int], columns: Sequence[int], n: int) -> Real:
    """(terms, n, n) symmetric residual terms of all pairs, from those (terms, outputs, inputs) at rows and columns."""
    whole = np.full((len(residual), n, n), np.nan)
    for k, i in enumerate(columns):
        whole[:, rows, i] = residual[:, :, k]
    whole = _reciprocal(whole)
    driven = [i for i in dict.fromkeys(columns) if i in rows]
    column = np.nan_to_num(whole[:, :, driven])
    inner = np.linalg.pinv(whole[:, driven][:, :, driven], rcond=SIGNIFICANT, hermitian=True)
    estimated = column @ inner @ column.transpose(0, 2, 1)
    return np.where(np.isnan(whole), estimated, whole)


def _reciprocal(whole: Real) -> Real:
    """The mean of each pair and the one exchanged, or the one of them that was measured."""
    other = whole.transpose(0, 2, 1)
    mean = (whole + other) / 2
    return np.where(np.isnan(mean), np.where(np.isnan(whole), other, whole), mean)
