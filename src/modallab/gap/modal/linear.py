"""The evidence of an explanation at any scale of what two tests differ by, from one linearisation.

Three things differ from test to test though nothing was changed, and one says nothing of another: each line by itself,
the shapes and what lies outside the band along whole FRFs, and the structure. Each has a scale of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.modal.fitting import FittedExplanation, inverse, slopes_by_differences
from modallab.gap.modal.free import Free
from modallab.gap.modal.weights import Weights


@dataclass(frozen=True, eq=False, slots=True)
class Linear:
    """An explanation about where it was fitted.

    Attributes:
        of: it.
        misfit: (lines, outputs, inputs) predicted less measured.
        slopes: (numbers, lines, outputs, inputs) of it by the tolerances, in their own units, and by the change.
    """

    of: FittedExplanation
    misfit: Complex
    slopes: Complex

    @classmethod
    def about(cls, fitted: FittedExplanation) -> "Linear":
        """Of a fit."""
        free = fitted.free
        predicted = free.predicted(fitted.u, fitted.change)
        by_tolerances = free.derivatives(fitted.u, fitted.change)
        own = slopes_by_differences(free, fitted.candidate, fitted.u, fitted.v, predicted)
        return cls(fitted, predicted - free.of.measured, np.concatenate([by_tolerances, own]))

    def weighed(self, weights: Weights) -> "WeightedSquares":
        """With its squares."""
        slopes = weights.weighed(self.slopes)
        misfit = weights.weighed(self.misfit[None])[:, 0]
        return WeightedSquares(self.of, slopes.T @ slopes, slopes.T @ misfit, float(misfit @ misfit), weights.logdet)


@dataclass(frozen=True, eq=False, slots=True)
class WeightedSquares:
    """The squares of a linearised misfit.

    Attributes:
        of: the fit.
        normal: (numbers, numbers) in own units.
        gradient: (numbers,).
        cost: of the misfit where it was fitted.
        logdet: of the covariance of lines.
    """

    of: FittedExplanation
    normal: Real
    gradient: Real
    cost: float
    logdet: float

    def evidence(self, structure: Real | float) -> float:
        """-2 ln of it where the structure differs by that factor more, at the best numbers there."""
        return self._at(structure)[0]

    def gained(self, wide: Real, scales: Sequence[float]) -> Real:
        """(numbers of the structure, scales) by how much -2 ln of it changes where one of them is that and not `wide`.

        One number of less weight changes the inverse of the normal matrix by a product of two vectors (Tipping and
        Faul, Proc. 9th Int. Workshop on Artificial Intelligence and Statistics, 2003).
        """
        _, found, variance = self._at(wide)
        before, *each = (replace(self.of.free, wide=w).deviations for w in (wide, *scales))
        n = self.of.free.structure_size
        after = np.array(each)[:, :n]
        # A number that is known has no deviation, at no scale.
        less = np.divide(before[:n], after, out=np.ones_like(after), where=after > 0).T ** 2 - 1
        kept = 1 + less * variance[:n, None]
        return np.asarray(less * found[:n, None] ** 2 / kept + np.log(kept) - np.log1p(less))

    def _at(self, structure: Real | float) -> tuple[float, Real, Real]:
        """The same, and the best numbers of the tolerances there with their variances, in deviations."""
        free: Free = replace(self.of.free, wide=structure)
        candidate, known, size = self.of.candidate, self.of.free.deviations, self.of.free.size
        unit = np.append(free.deviations, np.ones(self.of.v.size))
        weight = np.ones(size)
        off = self.of.u * np.divide(known, free.deviations, out=np.zeros_like(known), where=known > 0)
        room, believed = free.price, float(off @ off)
        begun = off
        if candidate is not None:
            own, pulled = candidate.pull(self.of.v)
            believed += float(np.sum(((self.of.v - candidate.centre) / candidate.prior) ** 2))
            weight, off = np.append(weight, own), np.append(off, pulled)
            room += candidate.room
        normal = self.normal * np.outer(unit, unit) + np.diag(weight)
        gradient = self.gradient * unit + off
        covariance, logdet = inverse(normal)
        covariance[~np.isfinite(covariance)] = 0.0
        step = covariance @ gradient
        evidence = self.cost + believed - gradient @ step + self.logdet + logdet + room
        return float(evidence), begun - step[:size], np.diag(covariance)[:size]
