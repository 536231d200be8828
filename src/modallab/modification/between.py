"""Values at points, taken along between them by radial functions.

The functions are r^5 with a quadratic part, which bend no border straight as r^3 does (Wendland, Scattered Data
Approximation, 2005, ch. 8).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, eq=False, slots=True)
class Between:
    """Values taken along in space.

    Attributes:
        known: (known, 3) places, centred and scaled.
        weights: (known + 10, columns) of the radial functions and the quadratic part.
        inverse: (known + 10, known + 10) of the system that gives the weights.
        rough: (columns,) deviation of the functions that go through such values, in the units of the kernel.
        middle: (3,) of the places, m.
        size: their extent, m.
    """

    known: Real
    weights: Complex | Real
    inverse: Real
    rough: Real
    middle: Real
    size: float

    @classmethod
    def of(cls, known_m: Real, values: Complex | Real) -> "Between":
        """Through values (known, columns) at places (known, 3)."""
        middle, size = known_m.mean(axis=0), max(float(np.ptp(known_m, axis=0).max()), 1e-9)
        known = (known_m - middle) / size
        part = _quadratic(known)
        terms = part.shape[1]
        whole = np.block([[_radial(known, known), part], [part.T, np.zeros((terms, terms))]])
        # Points in one plane, or few, leave coefficients of the quadratic part open: the smallest do.
        inverse = np.asarray(np.linalg.pinv(whole, rcond=1e-12), np.float64)
        weights = inverse @ np.concatenate([values, np.zeros((terms, values.shape[1]))])
        # -r^5 is the covariance of what the quadratic part leaves.
        power = -np.einsum("kc,kc->c", values.conj(), weights[: len(known)]).real
        free = max(len(known) - int(np.linalg.matrix_rank(part)), 1)
        return cls(known, weights, inverse, np.sqrt(np.maximum(power, 0.0) / free), middle, size)

    def at(self, places_m: Real) -> Complex | Real:
        """(places, columns) at places (places, 3)."""
        places = (places_m - self.middle) / self.size
        return self._terms(places) @ self.weights

    def rows(self, places_m: Real) -> Real:
        """(places, known) by which values at the known places add up to those at places (places, 3)."""
        return self._terms((places_m - self.middle) / self.size) @ self.inverse[:, : len(self.known)]

    def spread(self, places_m: Real) -> Real:
        """(places, columns) deviation of the values there: that of kriging, whose scale is how rough the values are."""
        terms = self._terms((places_m - self.middle) / self.size)
        square = np.einsum("pi,ij,pj->p", terms, self.inverse, terms)
        return np.sqrt(np.maximum(square, 0.0))[:, None] * self.rough

    def _terms(self, places: Real) -> Real:
        return np.concatenate([_radial(places, self.known), _quadratic(places)], axis=1)


def _radial(p: Real, q: Real) -> Real:
    return np.linalg.norm(p[:, None] - q[None], axis=2) ** 5


def _quadratic(p: Real) -> Real:
    i, j = np.triu_indices(3)
    return np.concatenate([np.ones((len(p), 1)), p, p[:, i] * p[:, j]], axis=1)
