"""Covariance-driven stochastic subspace identification (SSI-COV), with the poles' covariance to first order.

The block Hankel matrix of covariances is O C, O the observability matrix: its upper and lower part are a shift apart,
and A with O_lower = O_upper A has the structure's poles for eigenvalues. The covariances of segments scatter about
their mean; what each segment's deviation moves a pole by follows from the derivatives of the singular vectors, of A and
of its eigenvalues.
Sources: Peeters and De Roeck, "Reference-based stochastic subspace identification for output-only modal analysis",
MSSP 13 (1999); Reynders, Pintelon, De Roeck, "Uncertainty bounds on modal parameters obtained from stochastic subspace
identification", MSSP 22 (2008); Doehler and Mevel, "Efficient multi-order uncertainty computation for stochastic
subspace identification", MSSP 38 (2013).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real


@dataclass(frozen=True, eq=False, slots=True)
class OrderPolesWithSlopes:
    """The poles of one order, and how each segment's deviation moves them.

    Attributes:
        poles: (poles,) rad/s.
        shapes: (poles, outputs) 1 at the largest.
        moved: (segments, poles) of the poles.
        shapes_moved: (segments, poles, outputs) of the shapes.
    """

    poles: Complex128
    shapes: Complex128
    moved: Complex128
    shapes_moved: Complex128


class Subspace:
    """The signal subspace of covariances, up to a highest order.

    Args:
        covariances: (segments, lags, outputs, outputs); of an odd number of lags.
        rate_hz: of the lags.
        highest: order.
    """

    def __init__(self, covariances: Real, rate_hz: float, highest: int) -> None:
        self._rate_hz = rate_hz
        self._outputs = covariances.shape[-1]
        mean = covariances.mean(axis=0)
        u, s, vt = np.linalg.svd(_hankel(mean))
        self.highest = min(highest, int(np.count_nonzero(s > 1e-10 * s[0])) // 2 * 2)
        self._u, self._s, v = u[:, : self.highest], s[: self.highest], vt[: self.highest].T
        # Every segment's matrix is seen along the right singular vectors alone.
        self._moved = np.stack([_hankel(c - mean) @ v / self._s for c in covariances])
        self._along = self._u.T @ self._moved

    @property
    def orders(self) -> tuple[int, ...]:
        """Every second one."""
        return tuple(range(2, self.highest + 1, 2))

    def at(self, order: int) -> OrderPolesWithSlopes:
        """Poles of one order with what moves them."""
        o, a = self._system(order)
        values, right = (np.asarray(part, np.complex128) for part in np.linalg.eig(a))
        left = np.linalg.inv(right)
        keep, poles = _upper_half_plane(a, self._rate_hz, values)
        # A rotation of the subspace within itself moves neither poles nor shapes: only what leaves it counts.
        o_moved = self._moved[:, :, :order] - o @ self._along[:, :order, :order]
        a_moved = self._a_moved(o, a, o_moved)
        by_mode = np.asarray(left @ a_moved @ right, np.complex128)
        moved = np.asarray(np.diagonal(by_mode, axis1=1, axis2=2)[:, keep] * self._rate_hz / values[keep])
        shapes = np.asarray((o[: self._outputs] @ right)[:, keep].T)
        mixed = _mixing_of_eigenvectors(by_mode, values, keep)
        shapes_moved = (o_moved[:, : self._outputs] @ right)[:, :, keep] + (o[: self._outputs] @ right) @ mixed
        return OrderPolesWithSlopes(poles, *_scale_shapes(shapes, moved, shapes_moved.transpose(0, 2, 1)))

    def _system(self, order: int) -> tuple[Real, Real]:
        o, m = self._u[:, :order], self._outputs
        return o, np.linalg.lstsq(o[:-m], o[m:], rcond=None)[0]

    def _a_moved(self, o: Real, a: Real, o_moved: Real) -> Real:
        m = self._outputs
        upper, lower = o[:-m], o[m:]
        gram = np.linalg.inv(upper.T @ upper)
        change = upper.T @ (o_moved[:, m:] - o_moved[:, :-m] @ a)
        change = change + o_moved[:, :-m].transpose(0, 2, 1) @ (lower - upper @ a)
        return gram @ change


def _hankel(covariances: Real) -> Real:
    """(rows outputs, columns outputs) of (lags, outputs, outputs), one column less than rows."""
    lags, outputs, _ = covariances.shape
    rows = (lags + 2) // 2
    columns = lags + 1 - rows
    index = np.arange(rows)[:, None] + np.arange(columns)
    return covariances[index].transpose(0, 2, 1, 3).reshape(rows * outputs, columns * outputs)


def _upper_half_plane(
    a: Real, rate_hz: float, values: Complex128 | None = None
) -> tuple[NDArray[np.int64], Complex128]:
    """Places of the eigenvalues in the upper half-plane by rising frequency, and their poles in rad/s."""
    z = np.linalg.eigvals(a).astype(np.complex128) if values is None else values.astype(np.complex128)
    keep = np.flatnonzero((z.imag > 0) & (np.abs(z) > 1e-6))
    poles = np.asarray(np.log(z[keep]) * rate_hz, np.complex128)
    order = np.argsort(np.abs(poles))
    return keep[order], poles[order]


def _mixing_of_eigenvectors(by_mode: Complex128, values: Complex128, keep: NDArray[np.int64]) -> Complex128:
    """(segments, eigenvectors, kept) how much of the other eigenvectors each one takes up."""
    apart = values[keep] - values[:, None]
    own = np.abs(apart) < 1e-12
    mixed = by_mode[:, :, keep] / np.where(own, 1, apart)
    mixed[:, own] = 0
    return mixed


def unit_at_largest(shapes: Complex128, largest: NDArray[np.int64] | None = None) -> Complex128:
    """Shapes (modes, outputs) turned and scaled until one component is 1: the largest, or the one that is named."""
    at = np.argmax(np.abs(shapes), axis=1) if largest is None else largest
    return shapes / shapes[np.arange(len(shapes)), at][:, None]


def _scale_shapes(
    shapes: Complex128, moved: Complex128, shapes_moved: Complex128
) -> tuple[Complex128, Complex128, Complex128]:
    largest = np.argmax(np.abs(shapes), axis=1)
    rows = np.arange(len(shapes))
    scale = shapes[rows, largest][:, None]
    unit = shapes / scale
    unit_moved = (shapes_moved - unit * shapes_moved[:, rows, largest][..., None]) / scale
    return unit, moved, unit_moved
