"""The candidate that what a fit leaves of the records speaks for most.

Near the truth the records are linear in the nuisances, and tell more than modal rows, which forgive what identification
without a model cannot resolve. Each candidate is compared on its whole grid, the nuisances projected out (score test:
Rao, Math. Proc. Cambridge Phil. Soc. 44, 1948, 50).
"""

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from modallab.gap.inference.screen import SearchStart, best_share
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.minimise import jacobian
from modallab.gap.search.fitting import Bench
from modallab.twin.candidate import CandidateEffect

Array = NDArray[np.float64]


class ScoreTest:
    """What candidates would take from the cost of a fit, to first order in its own numbers."""

    def __init__(self, bench: Bench, fit: Fit) -> None:
        """Take the slopes of all numbers of the fit, on the records for a first look."""
        self.problem = replace(fit.problem, data=bench.thin)
        self.u, n = fit.u, bench.free.size
        self.r = self.problem.residual(fit.u)
        self.J = jacobian(self.problem, fit.u, self.r)
        _, slope, weight = self.problem.priors(fit.u)
        normal = self.J.T @ self.J
        normal[np.arange(n), np.arange(n)] += weight
        self.inverse = np.linalg.pinv(normal, hermitian=True)
        gradient = self.J.T @ self.r
        gradient[:n] += slope
        self.rest = self.r - self.J @ (self.inverse @ gradient)

    def best(self, candidates: Iterable[CandidateEffect]) -> SearchStart | None:
        """The grid point that takes most from the cost, with minus twice that as its score; None without candidates."""
        starts = [start for c in candidates for start in self._starts(c)]
        return min(starts, key=lambda s: s.score, default=None)

    def _starts(self, candidate: CandidateEffect) -> list[SearchStart]:
        problem = replace(self.problem, candidates=(*self.problem.candidates, candidate))
        grid = list(product(*([slot.coordinate(v) for v in slot.starts] for slot in candidate.slots)))
        return [self._start(problem, np.append(self.u, own)) for own in grid]

    def _start(self, problem: Problem, u: Array) -> SearchStart:
        try:
            change = problem.residual(u) - self.r
        except np.linalg.LinAlgError:
            # Two losses of stiffness at one place may leave none.
            return SearchStart(problem, u, np.inf)
        along = change - self.J @ (self.inverse @ (self.J.T @ change))
        share = best_share(float(change @ self.rest), float(change @ along))
        candidate, n = problem.candidates[-1], len(self.u)
        if share < 1 and candidate.size is not None:
            u = np.append(self.u, candidate.with_signature(u[n:], share))
            change, along = share * change, share * along
        return SearchStart(problem, u, float(2 * change @ self.rest + change @ along))
