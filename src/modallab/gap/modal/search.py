"""Which change explains best what the tolerances leave: Gauss-Newton with priors, screened by one step of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.gap.modal.candidates import Candidate, candidates
from modallab.gap.modal.free import NOTHING, Change, Free

Real = NDArray[np.float64]

STEPS = 8
FIRST_STEPS = 4
"""Of a fit that only says which of one kind is worth another."""
THIN = slice(None, None, 3)
"""Lines that are screened."""
REFINED = 2
"""Candidates of each kind that are fitted to the end."""
ENOUGH = 1e-3


@dataclass(frozen=True, eq=False, slots=True)
class Fitted:
    """An explanation.

    Attributes:
        candidate: the change; None for none.
        u: (numbers,) of the tolerances, in deviations.
        v: (numbers of the change,).
        cost: sum of squares of misfit and priors.
        covariance: of u and v.
    """

    candidate: Candidate | None
    u: Real
    v: Real
    cost: float
    covariance: Real

    @property
    def change(self) -> Change:
        """What was changed."""
        return NOTHING if self.candidate is None else self.candidate.make(self.v)


def fit(
    free: Free, candidate: Candidate | None = None, u: Real | None = None, v: Real | None = None, steps: int = STEPS
) -> Fitted:
    """Fit the tolerances, and a change, from a start; damped steps (Levenberg and Marquardt)."""
    u = np.zeros(free.size) if u is None else u
    v = np.zeros(0) if v is None else v
    damping, cost = 1e-3, _cost(free, candidate, u, v)
    before = cost
    for _ in range(steps):
        normal, gradient = _system(free, candidate, u, v)
        before = cost
        for _ in range(6):
            step = _step(normal, gradient, damping)
            trial = u + step[: u.size], v + step[u.size :]
            cost = _cost(free, candidate, *trial)
            if cost < before:
                u, v = trial
                break
            damping *= 10
        damping /= 10
        if cost >= before * (1 - ENOUGH):
            break
    cost = min(cost, before)
    normal, _ = _system(free, candidate, u, v)
    scale = np.sqrt(np.diag(normal))
    # A number that moves nothing is not known at all.
    unseen = np.flatnonzero(scale == 0)
    scale[unseen] = normal[unseen, unseen] = 1.0
    covariance = np.linalg.inv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    covariance[unseen, unseen] = np.inf
    return Fitted(candidate, u, v, cost, covariance)


def _step(normal: Real, gradient: Real, damping: float) -> Real:
    # Numbers of very different size: each is counted in its own deviation.
    scale = np.sqrt(np.diag(normal))
    even = normal / np.outer(scale, scale) + damping * np.eye(scale.size)
    return -np.linalg.solve(even, gradient / scale) / scale


def _cost(free: Free, candidate: Candidate | None, u: Real, v: Real) -> float:
    change = NOTHING if candidate is None else candidate.make(v)
    left = free.residual(u, change)
    believed = 0.0 if candidate is None else float(np.sum(((v - candidate.centre) / candidate.prior) ** 2))
    return float(left @ left + u @ u) + believed


def _system(free: Free, candidate: Candidate | None, u: Real, v: Real) -> tuple[Real, Real]:
    change = NOTHING if candidate is None else candidate.make(v)
    left = free.residual(u, change)
    jacobian = free.slopes(u, change)
    prior = np.ones(u.size)
    off = u.copy()
    if candidate is not None:
        steps = 1e-4 * np.maximum(np.abs(v), np.where(np.isfinite(candidate.prior), candidate.prior, 1e-2))
        own = [
            (free.residual(u, candidate.make(v + step * np.eye(v.size)[k])) - left) / step
            for k, step in enumerate(steps)
        ]
        jacobian = np.concatenate([jacobian, np.stack(own, axis=1)], axis=1)
        weight = 1 / candidate.prior**2
        prior = np.concatenate([prior, weight])
        off = np.concatenate([off, v - candidate.centre])
    return jacobian.T @ jacobian + np.diag(prior), jacobian.T @ left + prior * off


def screened(free: Free, base: Fitted) -> list[tuple[float, Candidate, Real]]:
    """Cost of each candidate at its best start, after one step of the tolerances; the least first."""
    jacobian = free.slopes(base.u, NOTHING, THIN)
    normal = jacobian.T @ jacobian + np.eye(free.size)
    found: list[tuple[float, Candidate, Real]] = []
    for candidate in candidates(free.of):
        costs: list[float] = []
        for start in candidate.starts:
            left = free.residual(base.u, candidate.make(start), THIN)
            gradient = jacobian.T @ left + base.u
            gain = gradient @ np.linalg.solve(normal, gradient)
            costs.append(float(left @ left + base.u @ base.u - gain))
        best = int(np.argmin(costs))
        found.append((costs[best], candidate, candidate.starts[best]))
    return sorted(found, key=lambda f: f[0])


def explanations(coarse: Free, fine: Free) -> tuple[Fitted, list[Fitted]]:
    """The fit without any change, and the best of each kind; the one that leaves least first.

    Args:
        coarse: smoothed so far that modes overlap with where they were, and loose: where the search begins.
        fine: what counts.
    """
    base = fit(coarse)
    tried: dict[str, list[Fitted]] = {}
    for _, candidate, start in screened(coarse, base):
        of_kind = tried.setdefault(candidate.effect, [])
        if len(of_kind) < REFINED:
            of_kind.append(fit(coarse, candidate, base.u, start, FIRST_STEPS))
    best = [min(group, key=lambda f: f.cost) for group in tried.values()]
    final = [fit(fine, f.candidate, f.u, f.v) for f in best]
    return fit(fine, None, base.u), sorted(final, key=lambda f: f.cost)
