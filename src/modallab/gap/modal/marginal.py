"""Changes on a comparison whose tolerances follow them linearly, so that each is fitted with its own numbers alone."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.modal.candidate import Candidate
from modallab.gap.modal.fitting import FIRST_STEPS, FittedExplanation, inverse, minimised, slopes_by_differences
from modallab.gap.modal.free import Free


@dataclass(frozen=True, eq=False, slots=True)
class Marginal:
    """A comparison about where its tolerances were fitted.

    Attributes:
        free: the comparison.
        u: (numbers,) of the tolerances there.
        jacobian: (misfits, numbers) of the misfits by them.
        normal: (numbers, numbers) with their priors.
        factor: (numbers, numbers) inverse of its Cholesky factor.
    """

    free: Free
    u: Real
    jacobian: Real
    normal: Real
    factor: Real

    @classmethod
    def about(cls, free: Free, u: Real) -> "Marginal":
        """About numbers of the tolerances."""
        jacobian = free.slopes(u)
        normal = jacobian.T @ jacobian + np.eye(free.size)
        return cls(free, u, jacobian, normal, np.asarray(np.linalg.inv(np.linalg.cholesky(normal)), np.float64))

    def _taken(self, misfits: Real, off: Real) -> Real:
        """(numbers, any) what the tolerances take of misfits (misfits, any) from where they are off by (numbers, 1)."""
        return np.asarray(self.factor @ (self.jacobian.T @ misfits + off), np.float64)

    def costs(self, misfits: Real) -> Real:
        """(any,) squares that misfits (misfits, any) leave once the tolerances have followed."""
        taken = self._taken(misfits, self.u[:, None])
        return np.sum(misfits**2, axis=0) + self.u @ self.u - np.sum(taken**2, axis=0)

    def started(self, candidate: Candidate) -> tuple[float, Real]:
        """Least cost of a candidate's starts, and that start."""
        misfits = (self.free.residual(self.u, candidate.make(start, self.free.of)) for start in candidate.starts)
        costs = self.costs(np.stack(list(misfits), axis=1))
        best = int(np.argmin(costs))
        return float(costs[best]), candidate.starts[best]

    def fit(self, candidate: Candidate, start: Real) -> FittedExplanation:
        """A change fitted from a start."""
        v, cost = minimised(
            lambda v: self._cost(candidate, v), lambda v: self._system(candidate, v), start, FIRST_STEPS
        )
        misfit, own = self._own(candidate, v)
        across = self.jacobian.T @ own
        corner = own.T @ own + np.diag(candidate.pull(v)[0])
        covariance, logdet = inverse(np.block([[self.normal, across], [across.T, corner]]))
        followed = self.u - self.factor.T @ self._taken(misfit[:, None], self.u[:, None])[:, 0]
        evidence = cost + self.free.of.weights.logdet + logdet + candidate.room + self.free.price
        return FittedExplanation(self.free, candidate, followed, v, cost, covariance, evidence)

    def _cost(self, candidate: Candidate, v: Real) -> float:
        misfit = self.free.residual(self.u, candidate.make(v, self.free.of))
        return float(self.costs(misfit[:, None])[0] + np.sum(((v - candidate.centre) / candidate.prior) ** 2))

    def _system(self, candidate: Candidate, v: Real) -> tuple[Real, Real]:
        misfit, own = self._own(candidate, v)
        taken = self._taken(misfit[:, None], self.u[:, None])
        with_it = self._taken(own, np.zeros((self.u.size, 1)))
        weight, pulled = candidate.pull(v)
        normal = own.T @ own - with_it.T @ with_it + np.diag(weight)
        return normal, own.T @ misfit - (with_it.T @ taken)[:, 0] + pulled

    def _own(self, candidate: Candidate, v: Real) -> tuple[Real, Real]:
        """The misfit (misfits,), and its derivatives (misfits, numbers) by the numbers of the change."""
        free = self.free
        predicted = free.predicted(self.u, candidate.make(v, free.of))
        own = free.weighed(slopes_by_differences(free, candidate, self.u, v, predicted))
        return free.weighed((predicted - free.of.measured)[None])[:, 0], own
