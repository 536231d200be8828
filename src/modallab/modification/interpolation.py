"""Values at points taken along in space: mode shapes between the points of a rig, or the nodes of a mesh.

Shapes of modes are smooth: the covariance is the squared exponential. It has one length along the structure and another
across: modes of a shell are short around and long along it. A part of the values is rough: it differs between points.
How long both lengths are, and how large that part is, the values show: each hypothesis counts by its evidence
(Rasmussen, Williams, Gaussian Processes for Machine Learning, 2006, ch. 5). Few points show little of it, and what lies
between them is then as uncertain as it should be.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from modallab.core.arrays import Complex, Real

LENGTHS = np.geomspace(0.05, 2.0, 12)
"""Lengths of the covariance over the extent of the points, each as likely as the other before values are known."""
RATIO = 0.7
"""Deviation of the logarithm of one length over the other."""
NOISE = 1e-3
"""By how much values at the points are off, over their size."""
ROUGH = (0.0, 1e-2, 1e-1)
"""Sizes of what is rough over what is smooth: what supports, sensors and identification do at each point."""
LEAST = 1e-3
"""A hypothesis that has less of the evidence in all columns does not count."""


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """Axes of the places: the first is the one along which they spread most.

    Attributes:
        axes: (3, 3) unit vectors.
        size: extent of the places, m.
    """

    axes: Real
    size: float

    @classmethod
    def of(cls, places_m: Real) -> "Frame":
        """Of places (places, 3)."""
        _, _, axes = np.linalg.svd(places_m - places_m.mean(axis=0))
        return cls(axes, max(float(np.ptp(places_m, axis=0).max()), 1e-9))

    def along(self, places_m: Real) -> Real:
        """(places, 3) over the extent."""
        return places_m @ self.axes.T / self.size


@dataclass(frozen=True, eq=False, slots=True)
class Kernels:
    """Covariances, each a hypothesis, over the variance of what is smooth.

    Attributes:
        lengths: (hypotheses, 2) along the first axis and across it.
        rough: (hypotheses,) size of what is rough over what is smooth.
    """

    lengths: Real
    rough: Real

    @classmethod
    def of(cls, rough: Sequence[float]) -> "Kernels":
        """All, with these sizes."""
        each = np.array([(one, other, size) for one in LENGTHS for other in LENGTHS for size in rough])
        return cls(each[:, :2], each[:, 2])

    @property
    def log_prior(self) -> Real:
        """(hypotheses,) of each."""
        return np.asarray(-((np.log(self.lengths[:, 0] / self.lengths[:, 1]) / RATIO) ** 2) / 2)

    def chosen(self, which: NDArray[np.intp]) -> "Kernels":
        """Some of them."""
        return Kernels(self.lengths[which], self.rough[which])

    def between(self, p: Real, q: Real) -> Real:
        """(hypotheses, p, q) for places (p, 3) and (q, 3)."""
        squares = (p[:, None] - q[None]) ** 2
        apart = np.stack([squares[..., 0], squares[..., 1] + squares[..., 2]])
        smooth = np.exp(-np.tensordot(1 / (2 * self.lengths**2), apart, axes=1))
        return np.asarray(smooth + self.rough[:, None, None] ** 2 * np.exp(-apart.sum(axis=0) / (2 * LENGTHS[0] ** 2)))

    def each_between(self, known: Real) -> Iterator[Real]:
        """(known, known) of one after the other: of many places all of them are too many."""
        return (self.chosen(np.array([n])).between(known, known)[0] for n in range(len(self.rough)))


@dataclass(frozen=True, eq=False, slots=True)
class SpatialInterpolation:
    """Values taken along in space.

    Attributes:
        frame: of the places.
        known: (known, 3) places in it.
        kernels: that count.
        whitening: (hypotheses, known, known) inverse of the Cholesky factor of the values' correlation.
        weights: (hypotheses, known, columns) of the correlation with the known places, for each hypothesis alone.
        variance: (hypotheses, columns) of the process.
        probability: (hypotheses, columns) of each.
    """

    frame: Frame
    known: Real
    kernels: Kernels
    whitening: Real
    weights: Complex | Real
    variance: Real
    probability: Real

    @classmethod
    def of(cls, known_m: Real, values: Complex | Real, rough: Sequence[float] = ROUGH) -> "SpatialInterpolation":
        """Through values (known, columns) at places (known, 3), of which a part of one of some sizes is rough."""
        frame, off = Frame.of(known_m), NOISE**2 * np.eye(len(known_m))
        known, kernels = frame.along(known_m), Kernels.of(rough)
        every = (_log_evidence(one + off, values) for one in kernels.each_between(known))
        logs = np.array(list(every)) + kernels.log_prior[:, None]
        mass = np.exp(logs - logs.max(axis=0))
        counts = np.flatnonzero((mass / mass.sum(axis=0)).max(axis=1) >= LEAST)
        kernels, mass = kernels.chosen(counts), mass[counts]
        whitening = np.asarray(np.linalg.inv(np.linalg.cholesky(kernels.between(known, known) + off)), np.float64)
        weights = whitening.transpose(0, 2, 1) @ (whitening @ values)
        return cls(frame, known, kernels, whitening, weights, _variance(whitening @ values), mass / mass.sum(axis=0))

    def at(self, places_m: Real) -> Complex | Real:
        """(places, columns) at places (places, 3)."""
        return np.einsum("hpk,hkc,hc->pc", self._terms(places_m), self.weights, self.probability, optimize=True)

    def interpolation_matrix(self, places_m: Real) -> Real:
        """(columns, places, known) by which values of a column add up to those at places (places, 3)."""
        each = self._terms(places_m) @ self.whitening.transpose(0, 2, 1) @ self.whitening
        return np.einsum("hpk,hc->cpk", each, self.probability)

    def uncertainty(self, places_m: Real, from_m: Real | None = None) -> Real:
        """(places, columns) deviation of the values there, or of by how much they differ from those at a place (3,).

        Within each hypothesis, and from one to another.
        """
        there, terms = self.frame.along(places_m), self._terms(places_m)
        before = np.repeat(1 + self.kernels.rough[:, None] ** 2, len(there), axis=1)
        if from_m is not None:
            terms = terms - self._terms(from_m[None])
            before = 2 * before - 2 * self.kernels.between(there, self.frame.along(from_m[None]))[:, :, 0]
        explained = terms @ self.whitening.transpose(0, 2, 1)
        left = np.maximum(before - np.sum(explained**2, axis=2), 0.0)
        each = terms @ self.weights
        apart = np.abs(each - np.einsum("hpc,hc->pc", each, self.probability)) ** 2
        return np.sqrt(np.einsum("hpc,hc->pc", left[:, :, None] * self.variance[:, None] + apart, self.probability))

    def rotated_phase(self, factors: Complex) -> "SpatialInterpolation":
        """With each column times a factor (columns,) of size 1."""
        return replace(self, weights=self.weights * factors)

    def _terms(self, places_m: Real) -> Real:
        return self.kernels.between(self.frame.along(places_m), self.known)


def _variance(whitened: NDArray[Any]) -> Real:
    """(..., columns) most probable variance of the process, of whitened values (..., known, columns)."""
    power = np.sum(np.abs(whitened) ** 2, axis=-2)
    return np.asarray(np.maximum(power, np.finfo(float).tiny) / whitened.shape[-2])


def _log_evidence(correlation: Real, values: Complex | Real) -> Real:
    """(columns,) of values at the most probable variance, given their correlation."""
    factor = np.linalg.cholesky(correlation)
    whitened = solve_triangular(factor, values, lower=True, check_finite=False)
    return np.asarray(-np.sum(np.log(np.diag(factor))) - len(values) * np.log(_variance(whitened)) / 2)
