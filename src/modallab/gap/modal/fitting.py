"""Fits of a comparison: Gauss-Newton with priors."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.modal.candidate import Candidate
from modallab.gap.modal.free import NOTHING, Change, Free

STEPS = 20
FIRST_STEPS = 6
"""Of a fit from which another one begins."""
ENOUGH = 1e-4
"""Relative decrease of the cost at which a fit ends."""


@dataclass(frozen=True, eq=False, slots=True)
class FittedExplanation:
    """An explanation.

    Attributes:
        free: the numbers of the comparison.
        candidate: the change; None for none.
        u: (numbers,) of the tolerances, in deviations.
        v: (numbers of the change,).
        cost: sum of squares of misfit and priors.
        covariance: of u and v.
        evidence: -2 ln of it, by Laplace, but for what all explanations of one comparison have in common.
    """

    free: Free
    candidate: Candidate | None
    u: Real
    v: Real
    cost: float
    covariance: Real
    evidence: float

    @property
    def change(self) -> Change:
        """What was changed."""
        return NOTHING if self.candidate is None else self.candidate.make(self.v, self.free.of)

    @property
    def missed(self) -> Real:
        """(lines, outputs, inputs) as `Free.missed`."""
        return self.free.missed(self.u, self.change)

    @property
    def share(self) -> float:
        """Its rms."""
        return float(np.sqrt(np.mean(self.missed**2)))


def fit(
    free: Free, candidate: Candidate | None = None, u: Real | None = None, v: Real | None = None, steps: int = STEPS
) -> FittedExplanation:
    """Fit the tolerances, and a change, from a start."""
    n = free.size
    begin = np.concatenate([np.zeros(n) if u is None else u, np.zeros(0) if v is None else v])
    found, cost = minimised(
        lambda x: _cost(free, candidate, x[:n], x[n:]), lambda x: _system(free, candidate, x[:n], x[n:]), begin, steps
    )
    normal, _ = _system(free, candidate, found[:n], found[n:])
    covariance, logdet = inverse(normal)
    open_ = 0.0 if candidate is None else candidate.room
    evidence = cost + free.of.weights.logdet + logdet + open_ + free.price
    return FittedExplanation(free, candidate, found[:n], found[n:], cost, covariance, evidence)


def minimised(
    cost: Callable[[Real], float], system: Callable[[Real], tuple[Real, Real]], start: Real, steps: int
) -> tuple[Real, float]:
    """Numbers of least cost near a start, and that cost; damped steps (Levenberg and Marquardt)."""
    x, now, damping = start, cost(start), 1e-3
    for _ in range(steps):
        normal, gradient = system(x)
        before = now
        for _ in range(6):
            trial = x + _step(normal, gradient, damping)
            value = _cost_or_none(cost, trial)
            if value < before:
                x, now = trial, value
                break
            damping *= 10
        damping /= 10
        if now >= before * (1 - ENOUGH):
            break
    return x, now


def _cost_or_none(cost: Callable[[Real], float], x: Real) -> float:
    """The cost; infinite where numbers overflow, or a structure has no flexibility: such a step is not taken."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            return cost(x)
    except np.linalg.LinAlgError:
        return np.inf


def inverse(normal: Real) -> tuple[Real, float]:
    """The inverse of a normal matrix, which it may change, and the logarithm of its determinant."""
    scale = np.sqrt(np.diag(normal))
    # A number that moves nothing is not known at all.
    unseen = np.flatnonzero(scale == 0)
    scale[unseen] = normal[unseen, unseen] = 1.0
    even = normal / np.outer(scale, scale)
    covariance = np.linalg.inv(even) / np.outer(scale, scale)
    covariance[unseen, unseen] = np.inf
    return covariance, float(np.linalg.slogdet(even)[1] + 2 * np.sum(np.log(scale)))


def _step(normal: Real, gradient: Real, damping: float) -> Real:
    # Numbers of very different size: each is counted in its own deviation. One that moves nothing stays where it is.
    scale = np.sqrt(np.diag(normal))
    scale = np.where(scale > 0, scale, 1.0)
    even = normal / np.outer(scale, scale) + damping * np.eye(scale.size)
    return -np.linalg.solve(even, gradient / scale) / scale


def _cost(free: Free, candidate: Candidate | None, u: Real, v: Real) -> float:
    change = NOTHING if candidate is None else candidate.make(v, free.of)
    left = free.residual(u, change)
    believed = 0.0 if candidate is None else float(np.sum(((v - candidate.centre) / candidate.prior) ** 2))
    return float(left @ left + u @ u) + believed


def _system(free: Free, candidate: Candidate | None, u: Real, v: Real) -> tuple[Real, Real]:
    change = NOTHING if candidate is None else candidate.make(v, free.of)
    predicted, jacobian = free.predicted(u, change), free.slopes(u, change)
    left = free.weighed((predicted - free.of.measured)[None])[:, 0]
    prior = np.ones(u.size)
    off = u
    if candidate is not None:
        own = free.weighed(slopes_by_differences(free, candidate, u, v, predicted))
        jacobian = np.concatenate([jacobian, own], axis=1)
        weight, pulled = candidate.pull(v)
        prior, off = np.concatenate([prior, weight]), np.concatenate([off, pulled])
    return jacobian.T @ jacobian + np.diag(prior), jacobian.T @ left + off


def slopes_by_differences(free: Free, candidate: Candidate | None, u: Real, v: Real, predicted: Complex) -> Complex:
    """(numbers of the change, lines, outputs, inputs) derivatives of what is predicted, by differences."""
    if candidate is None:
        return np.zeros((0, *predicted.shape), np.complex128)
    steps = 1e-4 * np.maximum(np.abs(v), np.where(np.isfinite(candidate.prior), candidate.prior, 1e-2))
    moved = (free.predicted(u, candidate.make(v + by, free.of)) for by in np.diag(steps))
    return np.stack([(there - predicted) / step for there, step in zip(moved, steps, strict=True)])
