"""A first look at every candidate on its whole grid of places and sizes, the nuisances integrated out.

About one set of nuisances the rows are linear in them: their integral is a Gaussian one, whatever the candidate does to
the prediction (marginal likelihood of a linear model: Bishop, Pattern Recognition and Machine Learning, 2006, ch. 3.5).
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from modallab.gap.inference.discrepancy import Levels
from modallab.gap.inference.posterior import bounds
from modallab.gap.inference.view import RowModel
from modallab.gap.model.fit import Problem
from modallab.twin.bench import Twin
from modallab.twin.candidate import CandidateEffect, FreeNumber

Array = NDArray[np.float64]

ROUNDS = 2
"""Steps of the nuisances, each with the scales of the discrepancy set anew."""
TRIES = 20
"""Predictions for each number of a candidate, at most, while a start is improved."""


def best_share(slope: float, curvature: float) -> float:
    """Share, 0 to 1, of a change by which a cost falls most.

    Args:
        slope: half the slope of the cost at no change, per unit of the share.
        curvature: half its second derivative.
    """
    return float(np.clip(-slope / curvature, 0.0, 1.0)) if curvature > 0 else 1.0


@dataclass(frozen=True, eq=False, slots=True)
class SearchStart:
    """Where a fit may begin.

    Attributes:
        problem: what to fit.
        u: (u,) the free numbers.
        score: -2 log of the marginal likelihood there.
    """

    problem: Problem
    u: Array
    score: float


@dataclass(frozen=True, eq=False, slots=True)
class GridStart(SearchStart):
    """A start from the grid of a candidate.

    Attributes:
        cell: (numbers,) which value of each number's grid it has.
    """

    cell: tuple[int, ...]


class Screen:
    """Marginal likelihoods of candidates beside a fit."""

    def __init__(self, view: RowModel, problem: Problem, u: Array) -> None:
        """Take the slopes of the nuisances, and of the effects already there, at u."""
        self.view, self.problem, self.u = view, problem, u
        twin = problem.twin(u)
        match = view.matched(twin)
        self.J = view.slopes(problem, u, match, view.predict(twin, match))
        n = problem.free.size
        # The numbers of effects already there have wide priors: a hundredth of a coordinate's curvature.
        self.prior: Array = np.where(np.arange(len(u)) < n, 1.0, 1e-2)
        self.normal: Array = self._normals()
        self.residual: Array = view.residual(twin)
        _, self.rest, levels = self._with_nuisances(self.residual)
        self.weights: Array = view.objective.weights(self.rest, levels)
        curvature: Array = (self.J.T * self.weights) @ self.J + np.diag(self.prior)
        self.inverse: Array = np.asarray(np.linalg.inv(curvature), np.float64)

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

    def starts(self, candidate: CandidateEffect, most: int) -> list[GridStart]:
        """The best places for a candidate to begin, each a local minimum of its grid, best first."""
        chosen: list[GridStart] = []
        for start in sorted(self._grid(candidate), key=lambda s: s.score):
            apart = (max((abs(k - j) for k, j in zip(start.cell, c.cell, strict=True)), default=0) for c in chosen)
            if len(chosen) < most and all(steps > 1 for steps in apart) and np.isfinite(start.score):
                chosen.append(start)
        return chosen

    def improved(self, start: GridStart) -> SearchStart:
        """The start moved to where its marginal likelihood is largest nearby, without slopes.

        Nelder and Mead, Comput. J. 7 (1965), 308: the answer of a law jumps where its numbers move steadily.
        """
        n, candidate = len(self.u), start.problem.candidates[-1]
        low, high = bounds((candidate,), start.problem.data.rig)
        steps = np.diag([_half_spacing(slot) for slot in candidate.slots])

        def score(own: Array) -> float:
            u = np.append(self.u, np.clip(own, low, high))
            return self._score_of(candidate, u, start.problem.twin(u), smallest=False)[1]

        simplex = start.u[n:] + np.vstack([np.zeros(len(steps)), steps])
        options = {"maxfev": TRIES * len(steps), "initial_simplex": simplex, "fatol": 0.5}
        found = minimize(score, simplex[0], method="Nelder-Mead", options=options)
        return SearchStart(start.problem, np.append(self.u, np.clip(found.x, low, high)), float(found.fun))

    def _grid(self, candidate: CandidateEffect) -> list[GridStart]:
        """The whole grid of a candidate; its smallest sizes are the most probable ones from there down to none."""
        problem = replace(self.problem, candidates=(*self.problem.candidates, candidate))
        cells = list(product(*(range(len(slot.starts)) for slot in candidate.slots)))
        own = [[slot.coordinate(slot.starts[k]) for slot, k in zip(candidate.slots, c, strict=True)] for c in cells]
        U = np.array([np.concatenate([self.u, numbers]) for numbers in own])
        weakest = [] if candidate.size is None else candidate.slots[candidate.size].weakest_starts
        found = []
        for cell, u, twin in zip(cells, U, problem.twins(U), strict=True):
            smallest = candidate.size is not None and cell[candidate.size] in weakest
            u, score = self._score_of(candidate, u, twin, smallest)
            found.append(GridStart(problem, u, score, cell))
        return found

    def _score_of(self, candidate: CandidateEffect, u: Array, twin: Twin, smallest: bool) -> tuple[Array, float]:
        """Numbers and score of a grid point, or of the smaller effect on the line to none that is more probable."""
        try:
            residual = self.view.residual(twin)
        except np.linalg.LinAlgError:
            # Two losses of stiffness at one place may leave none.
            return u, np.inf
        score = self._marginal(residual)
        share = self._share(residual - self.residual) if smallest else 1.0
        if share == 1:
            return u, score
        smaller = self._marginal(self.residual + share * (residual - self.residual))
        own = candidate.with_signature(u[len(self.u) :], share)
        return (np.append(self.u, own), smaller) if smaller < score else (u, score)

    def _share(self, change: Array) -> float:
        """Share of a change of the rows at which they are most probable, the nuisances projected out."""
        along = change - self.J @ (self.inverse @ (self.J.T @ (self.weights * change)))
        return best_share(float(along @ (self.weights * self.rest)), float(along @ (self.weights * change)))

    def _marginal(self, residual: Array) -> float:
        """-2 log of the marginal likelihood, the scales at their most probable values."""
        return self._with_nuisances(residual)[0]

    def _with_nuisances(self, residual: Array) -> tuple[float, Array, Levels]:
        """The same, with what the most probable nuisances leave of the rows and the scales there."""
        objective, moved, rest, best = self.view.objective, np.zeros(len(self.u)), residual, np.inf
        levels = objective.levels(rest)
        for turn in range(ROUNDS + 1):
            factor = cho_factor(self._curvature(levels), check_finite=False)
            u = self.u + moved
            volume = 2 * float(np.sum(np.log(np.diag(factor[0]))))
            best = min(best, objective.cost(rest, levels) + float(u @ (self.prior * u)) + volume)
            if turn < ROUNDS:
                weights = objective.weights(rest, levels)
                downhill: Array = self.J.T @ (weights * rest) - self.prior * u
                moved = moved + cho_solve(factor, downhill, check_finite=False)
                rest = residual - self.J @ moved
                levels = objective.levels(rest)
        return best, rest, levels

    def _curvature(self, levels: Levels) -> Array:
        """(u, u) curvature of the nuisances, and of the effects already there, at these scales."""
        groups = np.arange(self.normal.shape[1])
        curvature: Array = self.normal[levels, groups].sum(axis=0) + np.diag(self.prior)
        return curvature


def _half_spacing(slot: FreeNumber) -> float:
    """Half of what lies between two starts of a number, as a coordinate; of one start, 0.3, of a place, 0.015."""
    at = [slot.coordinate(v) for v in slot.starts]
    return float(np.min(np.diff(at))) / 2 if len(at) > 1 else 0.015 if slot.name == "x" else 0.3
