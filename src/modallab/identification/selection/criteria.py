"""Assurance criteria and indices of mode shapes.

Sources: Allemang, "The modal assurance criterion: twenty years of use and abuse", Sound and Vibration (2003); Pappa,
Elliott, Schenk, "Consistent-mode indicator for the eigensystem realization algorithm", J. Guidance 16 (1993) for MPC;
Lieven and Ewins, "Spatial correlation of mode shapes, the coordinate modal assurance criterion", IMAC 6 (1988).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError


def mac(one: NDArray[Any], other: NDArray[Any]) -> Real:
    """MAC (modes of one, modes of other): |a^H b|^2 / (a^H a b^H b), 1 for shapes alike up to a factor.

    Args:
        one: (modes, points) real or complex.
        other: (modes, points).

    Raises:
        DataError: shapes over different points, not finite, or zero.
    """
    _check_shapes(one)
    _check_shapes(other)
    if one.shape[1] != other.shape[1]:
        raise DataError(
            f"shapes over {one.shape[1]} and {other.shape[1]} points cannot be compared",
            remedy="take the points that both have",
        )
    cross = np.abs(one.conj() @ other.T) ** 2
    return cross / np.outer(np.sum(np.abs(one) ** 2, axis=1), np.sum(np.abs(other) ** 2, axis=1))


def auto_mac(shapes: NDArray[Any]) -> Real:
    """MAC of a set with itself: modes with a high value off the diagonal cannot be distinguished with so few points."""
    return mac(shapes, shapes)


def comac(one: NDArray[Any], other: NDArray[Any]) -> Real:
    """Coordinate MAC (points,) of paired modes: low where a point disagrees in many modes, as a wrong sensor does.

    (sum over modes |a_p b_p|)^2 / (sum |a_p|^2 sum |b_p|^2), shapes first scaled to unit length.

    Raises:
        DataError: as for `mac`, or numbers of modes that differ.
    """
    _check_shapes(one)
    _check_shapes(other)
    if one.shape != other.shape:
        raise DataError(
            f"shapes {one.shape} and {other.shape} are not paired", remedy="give the same modes at the same points"
        )
    a = one / np.linalg.norm(one, axis=1, keepdims=True)
    b = other / np.linalg.norm(other, axis=1, keepdims=True)
    power = np.sum(np.abs(a) ** 2, axis=0) * np.sum(np.abs(b) ** 2, axis=0)
    cross = np.sum(np.abs(a * b.conj()), axis=0) ** 2
    return np.divide(cross, power, out=np.ones_like(cross), where=power > 0)


def mpc(shapes: NDArray[Any]) -> Real:
    """Modal phase collinearity (modes,): 1 for a shape whose points all move in phase or against it, 0 for a circle.

    Of the real and imaginary parts' scatter matrix with eigenvalues l1, l2: ((l1 - l2) / (l1 + l2))^2.
    """
    _check_shapes(shapes)
    spread = np.linalg.eigvalsh(_scatter_matrix(shapes))
    return ((spread[:, 1] - spread[:, 0]) / (spread[:, 1] + spread[:, 0])) ** 2


def mpd(shapes: NDArray[Any]) -> Real:
    """Mean phase deviation (modes,) in rad from the shape's own straight line, weighted by amplitude: 0 to pi / 2."""
    _check_shapes(shapes)
    _, vectors = np.linalg.eigh(_scatter_matrix(shapes))
    line = vectors[:, :, 1]
    along = np.abs(np.real(shapes) * line[:, :1] + np.imag(shapes) * line[:, 1:])
    size = np.abs(shapes)
    angle = np.arccos(np.clip(np.divide(along, size, out=np.ones_like(size), where=size > 0), 0, 1))
    return np.sum(size * angle, axis=1) / np.sum(size, axis=1)


def _scatter_matrix(shapes: NDArray[Any]) -> Real:
    parts = np.stack([np.real(shapes), np.imag(shapes)], axis=1).astype(np.float64)
    return parts @ parts.transpose(0, 2, 1)


def _check_shapes(shapes: NDArray[Any]) -> None:
    if shapes.ndim != 2 or not shapes.size or not np.isfinite(shapes).all():
        raise DataError(
            f"the shapes have shape {shapes.shape}, or hold NaN, or nothing",
            remedy="give finite numbers, (modes, points)",
        )
    if not np.any(shapes != 0, axis=1).all():
        raise DataError("a mode shape is zero at every point", remedy="leave that mode out")


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
