"""Values at points, taken along between them by a Gaussian process (kriging).

Shapes of modes are smooth: the covariance is the squared exponential. How long their waves are, the values themselves
show: each length counts by its evidence (Rasmussen, Williams, Gaussian Processes for Machine Learning, 2006, ch. 5).
Few points show little of it, and what lies between them is then as uncertain as it should be.
"""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real

LENGTHS = np.geomspace(0.05, 2.0, 12)
"""Lengths of the covariance over the extent of the points, each as likely as the other before values are known."""
NOISE = 1e-3
"""By how much values at the points are off, over their size: what identification leaves of a shape."""


@dataclass(frozen=True, eq=False, slots=True)
class SpatialInterpolation:
    """Values taken along in space.

    Attributes:
        known: (known, 3) places over their extent.
        whitening: (lengths, known, known) inverse of the Cholesky factor of the values' correlation.
        weights: (lengths, known, columns) of the correlation with the known places, for each length alone.
        variance: (lengths, columns) of the process.
        probability: (lengths, columns) of each length.
        size: extent of the places, m.
    """

    known: Real
    whitening: Real
    weights: Complex | Real
    variance: Real
    probability: Real
    size: float

    @classmethod
    def of(cls, known_m: Real, values: Complex | Real) -> "SpatialInterpolation":
        """Through values (known, columns) at places (known, 3)."""
        size, count = max(float(np.ptp(known_m, axis=0).max()), 1e-9), len(known_m)
        known = known_m / size
        factor = np.linalg.cholesky(_correlation(known, known) + NOISE**2 * np.eye(count))
        whitening = np.asarray(np.linalg.inv(factor), np.float64)
        weights = whitening.transpose(0, 2, 1) @ (whitening @ values)
        power = np.einsum("kc,lkc->lc", values.conj(), weights).real
        variance = np.maximum(power, np.finfo(float).tiny) / count
        logs = np.sum(np.log(np.diagonal(whitening, axis1=1, axis2=2)), axis=1)[:, None] - count * np.log(variance) / 2
        mass = np.exp(logs - logs.max(axis=0))
        return cls(known, whitening, weights, variance, mass / mass.sum(axis=0), size)

    def at(self, places_m: Real) -> Complex | Real:
        """(places, columns) at places (places, 3)."""
        return np.einsum("lpk,lkc,lc->pc", self._terms(places_m), self.weights, self.probability, optimize=True)

    def rows(self, places_m: Real) -> Real:
        """(columns, places, known) by which values of a column add up to those at places (places, 3)."""
        each = self._terms(places_m) @ self.whitening.transpose(0, 2, 1) @ self.whitening
        return np.einsum("lpk,lc->cpk", each, self.probability)

    def spread(self, places_m: Real) -> Real:
        """(places, columns) deviation of the values there: within each length, and from one length to another."""
        terms = self._terms(places_m)
        explained = terms @ self.whitening.transpose(0, 2, 1)
        left = np.maximum(1 - np.sum(explained**2, axis=2), 0.0)
        each = terms @ self.weights
        apart = np.abs(each - np.einsum("lpc,lc->pc", each, self.probability)) ** 2
        return np.sqrt(np.einsum("lpc,lc->pc", left[:, :, None] * self.variance[:, None] + apart, self.probability))

    def turned(self, factors: Complex) -> "SpatialInterpolation":
        """With each column times a factor (columns,) of size 1."""
        return replace(self, weights=self.weights * factors)

    def _terms(self, places_m: Real) -> Real:
        return _correlation(places_m / self.size, self.known)


def _correlation(p: Real, q: Real) -> Real:
    """(lengths, p, q) between places (p, 3) and (q, 3)."""
    away = np.linalg.norm(p[:, None] - q[None], axis=2) / LENGTHS[:, None, None]
    return np.asarray(np.exp(-(away**2) / 2), np.float64)
