"""Which change explains best what the tolerances leave: Gauss-Newton with priors, screened by one step of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.gap.modal.candidates import Candidate, candidates, nearby
from modallab.gap.modal.free import NOTHING, Change, Free

Real = NDArray[np.float64]

STEPS = 8
FIRST_STEPS = 4
"""Of a fit that only says which of one kind is worth another."""
THIN = slice(None, None, 2)
"""Lines on which the search begins."""
REFINED = 2
"""Candidates of each kind that are fitted where the search begins."""
LIKELY = 3
"""Kinds that are fitted to the end."""
NEARBY = 3
"""Points about the place that was found, from which it is looked for again."""
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
        measured: whether the size comes from the measured FRFs themselves.
    """

    candidate: Candidate | None
    u: Real
    v: Real
    cost: float
    covariance: Real
    measured: bool = False

    @property
    def counted(self) -> float:
        """The cost, and what the numbers beside the change could have been over what they are found to be.

        That is what their evidence adds (Laplace): numbers that fit anything explain little.
        """
        beside = 0 if self.candidate is None else self.candidate.beside
        if not beside:
            return self.cost
        prior = 2 * np.sum(np.log(self.candidate.prior[-beside:])) if self.candidate is not None else 0.0
        return self.cost + float(prior - np.linalg.slogdet(self.covariance[-beside:, -beside:])[1])

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
    # Numbers of very different size: each is counted in its own deviation. One that moves nothing stays where it is.
    scale = np.sqrt(np.diag(normal))
    scale = np.where(scale > 0, scale, 1.0)
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


def screened(free: Free) -> list[tuple[float, Candidate, Real]]:
    """Cost of each candidate at its best start, after one step of the tolerances from what is believed; least first."""
    u = np.zeros(free.size)
    jacobian = free.slopes(u)
    normal = np.linalg.inv(jacobian.T @ jacobian + np.eye(free.size))
    found: list[tuple[float, Candidate, Real]] = []
    for candidate in candidates(free.of):
        left = np.stack([free.residual(u, candidate.make(start)) for start in candidate.starts], axis=1)
        gradient = jacobian.T @ left
        costs = np.sum(left**2, axis=0) - np.sum(gradient * (normal @ gradient), axis=0)
        best = int(np.argmin(costs))
        found.append((float(costs[best]), candidate, candidate.starts[best]))
    return sorted(found, key=lambda f: f[0])


def explanations(levels: Sequence[Free]) -> tuple[Fitted, list[Fitted]]:
    """The fit without any change, and the best of the likely kinds; the one that leaves least first.

    Args:
        levels: the comparison from the smoothest, where modes overlap with where they were, to the one that counts.
    """
    thin = Free(levels[0].of.thinned(THIN), levels[0].loose)
    ways = (thin, *levels[1:])
    base = _followed(ways, None, None)
    tried: dict[str, list[Fitted]] = {}
    for _, candidate, start in screened(thin):
        of_kind = tried.setdefault(candidate.effect, [])
        if len(of_kind) < (REFINED if candidate.freedoms else 1):
            of_kind.append(fit(thin, candidate, None, start, FIRST_STEPS))
    likely = sorted((min(group, key=lambda f: f.cost) for group in tried.values()), key=lambda f: f.cost)
    final = sorted((_followed(ways[1:], f, f.candidate) for f in likely[:LIKELY]), key=lambda f: f.counted)
    final[0] = _from_nearby(levels[-2], levels[-1], final[0])
    return base, final


def _followed(levels: Sequence[Free], start: Fitted | None, candidate: Candidate | None) -> Fitted:
    """A fit from level to level, to its end at the last."""
    found = start
    for n, level in enumerate(levels):
        u, v = (None, None) if found is None else (found.u, found.v)
        found = fit(level, candidate, u, v, STEPS if n == len(levels) - 1 else FIRST_STEPS)
    assert found is not None
    return found


def _from_nearby(closer: Free, fine: Free, best: Fitted) -> Fitted:
    """The best of it and of fits begun at points nearby: along a wave one place may stand for another."""
    if best.candidate is None or not best.candidate.freedoms:
        return best
    starts = nearby(fine.of, best.candidate, best.v, NEARBY)
    nearly = [fit(closer, candidate, best.u, v, FIRST_STEPS) for candidate, v in starts]
    other = min(nearly, key=lambda f: f.cost, default=best)
    return min(best, fit(fine, other.candidate, other.u, other.v), key=lambda f: f.cost)
