"""A first look at every candidate on its whole grid of places and sizes, the nuisances integrated out.

About one set of nuisances the rows are linear in them: their integral is a Gaussian one, whatever the candidate does to
the prediction (marginal likelihood of a linear model: Bishop, Pattern Recognition and Machine Learning, 2006, ch. 3.5).
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from modallab.gap.inference.view import View
from modallab.gap.model.fit import Problem
from modallab.twin.bench import Twin
from modallab.twin.candidate import Candidate

Array = NDArray[np.float64]

ROUNDS = 2
"""Steps of the nuisances, each with the scales of the discrepancy set anew."""


@dataclass(frozen=True, eq=False, slots=True)
class Start:
    """Where a fit may begin, and -2 log of the marginal likelihood there."""

    problem: Problem
    u: Array
    score: float


class Screen:
    """Marginal likelihoods of candidates beside a fit."""

    def __init__(self, view: View, problem: Problem, u: Array) -> None:
        """Take the slopes of the nuisances, and of the effects already there, at u."""
        self.view, self.problem, self.u = view, problem, u
        twin = problem.twin(u)
        match = view.matched(twin)
        self.J = view.slopes(problem, u, match, view.predict(twin, match))
        n = problem.free.size
        # The numbers of effects already there have wide priors: a hundredth of a coordinate's curvature.
        self.prior: Array = np.where(np.arange(len(u)) < n, 1.0, 1e-2)
        self.normal: Array = self._normals()

    def _normals(self) -> Array:
        """(scales, groups, u, u) curvature of each group of rows at each value of its scale."""
        objective, J = self.view.objective, self.J
        groups = [np.flatnonzero(objective.rows.group == k) for k in range(len(objective.rows.names))]
        return np.array(
            [
                [(J[own] * objective.precisions(level, own)[:, None]).T @ J[own] for own in groups]
                for level in range(len(objective.scales))
            ]
        )

    def starts(self, candidate: Candidate, most: int) -> list[Start]:
        """The best places for a candidate to begin, each a local minimum of its grid, best first."""
        problem = replace(self.problem, candidates=(*self.problem.candidates, candidate))
        axes = [[slot.coordinate(v) for v in slot.starts] for slot in candidate.slots]
        cells = np.array(list(product(*(range(len(a)) for a in axes))))
        grid = np.array(list(product(*axes)))
        U = np.array([np.concatenate([self.u, own]) for own in grid])
        scores = np.array([self._score(twin) for twin in problem.twins(U)])
        chosen: list[int] = []
        for k in np.argsort(scores):
            if len(chosen) < most and all(np.max(np.abs(cells[k] - cells[j])) > 1 for j in chosen):
                chosen.append(int(k))
        return [Start(problem, U[k], float(scores[k])) for k in chosen if np.isfinite(scores[k])]

    def _score(self, twin: Twin) -> float:
        try:
            residual = self.view.residual(twin)
        except np.linalg.LinAlgError:
            # Two losses of stiffness at one place may leave none.
            return np.inf
        return self._marginal(residual)

    def _marginal(self, residual: Array) -> float:
        """-2 log of the marginal likelihood, the scales at their most probable values."""
        objective, moved, rest, best = self.view.objective, np.zeros(len(self.u)), residual, np.inf
        groups = np.arange(self.normal.shape[1])
        for turn in range(ROUNDS + 1):
            levels = objective.levels(rest)
            curvature: Array = self.normal[levels, groups].sum(axis=0) + np.diag(self.prior)
            factor = cho_factor(curvature, check_finite=False)
            u = self.u + moved
            volume = 2 * float(np.sum(np.log(np.diag(factor[0]))))
            best = min(best, objective.cost(rest, levels) + float(u @ (self.prior * u)) + volume)
            if turn < ROUNDS:
                weights = objective.weights(rest, levels)
                downhill: Array = self.J.T @ (weights * rest) - self.prior * u
                moved = moved + cho_solve(factor, downhill, check_finite=False)
                rest = residual - self.J @ moved
        return best
