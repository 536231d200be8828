"""What modes outside the band add at pairs that were not measured.

Whatever they add at two points is the product of their shapes there. Where the shapes of a point are those of the
driven points, in fixed shares, the driven columns tell its other pairs: T R_dd T^T with T = R_jd (R_dd)^-1, the
Nystroem form of a matrix of low rank (Halko, Martinsson, Tropp, SIAM Review 53 (2011), section 5).

Other modes may move a point and none of the driven ones; then that form is zero at its own pair, which never is. What
is left there does not depend on what the driven columns tell (Muirhead, Aspects of Multivariate Statistical Theory
(1982), theorem 3.2.10). Modes outside the band move a point as much, on average, as those within it do, and the driven
pairs say how much that is. It is as uncertain as a sum of two squares: its standard deviation is its size.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from modallab.core.arrays import Real

SIGNIFICANT = 0.1
"""Of the largest eigenvalue among the driven points: smaller ones are noise, and their inverse would be as well."""
WITHIN = np.linspace(0.25, 0.75, 11)
"""Of the band: where terms are compared. At its ends single powers are large and cancel."""
SQUARES = 2
"""Of how many the uncertain term is the sum."""


class OutsideBand(NamedTuple):
    """Residual terms of all pairs.

    Attributes:
        terms: (terms, freedoms, freedoms) symmetric.
        alone: (terms, freedoms) what of a point's own pair no driven column tells; in `terms`.
    """

    terms: Real
    alone: Real


def residual_terms_of_structure(
    terms: Real, powers: Sequence[int], rows: Sequence[int], columns: Sequence[int], moved: Real
) -> Real:
    """Residual terms without that in s^-2, where no mode below the band leaves it.

    Each mode below the band moves the driven points about as much as one within it, so that the term says how many
    there are. Where the nearest whole number is none, it is what the measuring chain and the fit leave: little at the
    lines, but without bound below the lowest mode.

    Args:
        terms: (terms, outputs, inputs).
        powers: (terms,) of s.
        rows: (outputs,) places among the freedoms.
        columns: (inputs,) the same.
        moved: (freedoms,) squared shapes at unit modal mass, the mean of the modes.
    """
    below = np.array(powers) == -2
    own = [(rows.index(i), k, i) for k, i in enumerate(columns) if i in rows]
    counted, each = (sum(v) for v in ([np.sum(terms[below, o, k]) for o, k, _ in own], [moved[i] for *_, i in own]))
    none = each > 0 and round(float(counted / each)) < 1
    return np.where(below[:, None, None] & none, 0.0, terms)


def complete_residual_terms(
    residual: Real, powers: Sequence[int], rows: Sequence[int], columns: Sequence[int], moved: Real, high_hz: float
) -> OutsideBand:
    """Residual terms of all pairs, from those of some.

    Args:
        residual: (terms, outputs, inputs) as they were measured.
        powers: (terms,) of s.
        rows: (outputs,) places among the freedoms.
        columns: (inputs,) the same.
        moved: (freedoms,) sum of the squared shapes within the band, each at unit modal mass.
        high_hz: upper end of the band.
    """
    whole = np.full((len(residual), moved.size, moved.size), np.nan)
    for k, i in enumerate(columns):
        whole[:, rows, i] = residual[:, :, k]
    whole = _make_reciprocal(whole)
    driven = [i for i in dict.fromkeys(columns) if i in rows]
    column, at = np.nan_to_num(whole[:, :, driven]), 2j * np.pi * high_hz * WITHIN[:, None]
    weights = np.mean(np.real(at ** np.array(powers, np.float64)), axis=0)
    shares = _shares_of_driven(np.tensordot(weights, column, 1), driven)
    inner, among = column[:, driven], np.sum(moved[driven])
    own = np.trace(inner, axis1=1, axis2=2)[:, None] * (moved / among if among else 0 * moved)
    unknown = np.isnan(whole)
    alone = np.where(np.diagonal(unknown, axis1=1, axis2=2), own, 0.0)
    estimated = shares @ inner @ shares.T + alone[:, :, None] * np.eye(moved.size)
    return OutsideBand(np.where(unknown, estimated, whole), alone)


def _shares_of_driven(column: Real, driven: Sequence[int]) -> Real:
    """(freedoms, driven) shares of the driven points in the shapes of all."""
    return np.asarray(column @ np.linalg.pinv(column[driven], rcond=SIGNIFICANT, hermitian=True))


def draw_residual_terms(alone: Real, squares: Real) -> Real:
    """(samples, terms, freedoms, freedoms) of what no driven column tells.

    Args:
        alone: (terms, freedoms) what is expected of it at each point's own pair.
        squares: (samples, freedoms, SQUARES) normal numbers.
    """
    root = np.sqrt(np.abs(alone))
    expected = np.sign(alone.sum(axis=1))[:, None, None] * root[:, :, None] * root[:, None, :]
    return np.asarray(expected * (squares @ squares.swapaxes(1, 2) / SQUARES)[:, None])


def _make_reciprocal(whole: Real) -> Real:
    """The mean of each pair and the one exchanged, or the one of them that was measured."""
    other = whole.transpose(0, 2, 1)
    mean = (whole + other) / 2
    return np.where(np.isnan(mean), np.where(np.isnan(whole), other, whole), mean)
