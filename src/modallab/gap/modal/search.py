"""Which change explains best what the tolerances leave: Gauss-Newton with priors, screened by one step of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.gap.modal.candidate import Candidate
from modallab.gap.modal.candidates import candidates
from modallab.gap.modal.free import NOTHING, Change, Free
from modallab.gap.modal.hanging import nearby

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

STEPS = 20
FIRST_STEPS = 6
"""Of a fit from which another one begins."""
THIN = slice(None, None, 2)
"""Lines on which the search begins."""
REFINED = 2
"""Candidates of each kind that are fitted where the search begins."""
NEARBY = 3
"""Points about the place that was found, from which it is looked for again."""
ENOUGH = 1e-4
"""Relative decrease of the cost at which a fit ends."""


@dataclass(frozen=True, eq=False, slots=True)
class Fitted:
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
    covariance, logdet = inverse(normal)
    open_ = 0.0 if candidate is None else candidate.room
    return Fitted(free, candidate, u, v, cost, covariance, cost + free.of.weights.logdet + logdet + open_)


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
    left = free.residual(u, change)
    jacobian = free.slopes(u, change)
    prior = np.ones(u.size)
    off = u.copy()
    if candidate is not None:
        predicted = free.predicted(u, change)
        own = free.of.weights.weighed(own_slopes(free, candidate, u, v, predicted)) / free.loose
        jacobian = np.concatenate([jacobian, own], axis=1)
        weight = 1 / candidate.prior**2
        prior = np.concatenate([prior, weight])
        off = np.concatenate([off, v - candidate.centre])
    return jacobian.T @ jacobian + np.diag(prior), jacobian.T @ left + prior * off


def own_slopes(free: Free, candidate: Candidate | None, u: Real, v: Real, predicted: Complex) -> Complex:
    """(numbers of the change, lines, outputs, inputs) derivatives of what is predicted, by differences."""
    if candidate is None:
        return np.zeros((0, *predicted.shape), np.complex128)
    steps = 1e-4 * np.maximum(np.abs(v), np.where(np.isfinite(candidate.prior), candidate.prior, 1e-2))
    moved = (free.predicted(u, candidate.make(v + by, free.of)) for by in np.diag(steps))
    return np.stack([(there - predicted) / step for there, step in zip(moved, steps, strict=True)])


def screened(free: Free) -> list[tuple[float, Candidate, Real]]:
    """Cost of each candidate at its best start, after one step of the tolerances from what is believed; least first."""
    u = np.zeros(free.size)
    jacobian = free.slopes(u)
    normal = np.linalg.inv(jacobian.T @ jacobian + np.eye(free.size))
    found: list[tuple[float, Candidate, Real]] = []
    for candidate in candidates(free.of):
        left = np.stack([free.residual(u, candidate.make(start, free.of)) for start in candidate.starts], axis=1)
        gradient = jacobian.T @ left
        costs = np.sum(left**2, axis=0) - np.sum(gradient * (normal @ gradient), axis=0)
        best = int(np.argmin(costs))
        found.append((float(costs[best]), candidate, candidate.starts[best]))
    return sorted(found, key=lambda f: f[0])


def explanations(levels: Sequence[Free]) -> tuple[Fitted, list[Fitted]]:
    """The fit without any change, and the best of each kind.

    Args:
        levels: the comparison from the smoothest, where modes overlap with where they were, to the one that counts.
    """
    thin = Free(levels[0].of.thinned(THIN), levels[0].loose)
    ways = (thin, *levels[1:])
    base = _followed(ways, None, None)
    # A large change is seen from afar, a small one on the lines that count.
    far, near = _begun(thin), _begun(levels[-1])
    found: dict[str, list[Fitted]] = {}
    for fitted in [*(_followed(ways[1:], f, f.candidate) for f in far), *near]:
        assert fitted.candidate is not None
        found.setdefault(fitted.candidate.effect, []).append(fitted)
    best = [min(group, key=lambda f: f.evidence) for group in found.values()]
    return base, [_from_nearby(levels[-2], levels[-1], f) for f in best]


def _begun(free: Free) -> list[Fitted]:
    """The likely candidates of each kind, fitted from their best starts."""
    tried: dict[str, list[Fitted]] = {}
    for _, candidate, start in screened(free):
        of_kind = tried.setdefault(candidate.effect, [])
        if len(of_kind) < REFINED:
            of_kind.append(fit(free, candidate, None, start, FIRST_STEPS))
    return [f for group in tried.values() for f in group]


def _followed(levels: Sequence[Free], start: Fitted | None, candidate: Candidate | None) -> Fitted:
    """A fit from level to level, to its end at the last."""
    found = start
    for level in levels:
        u, v = (None, None) if found is None else (found.u, found.v)
        found = fit(level, candidate, u, v, FIRST_STEPS)
    assert found is not None
    return found


def _from_nearby(closer: Free, fine: Free, best: Fitted) -> Fitted:
    """The best of it and of fits begun at points nearby: along a wave one place may stand for another."""
    if best.candidate is None or not best.candidate.freedoms:
        return best
    starts = nearby(fine.of, best.candidate, best.v, NEARBY)
    nearly = [fit(closer, candidate, best.u, v) for candidate, v in starts]
    other = min(nearly, key=lambda f: f.cost, default=best)
    return min(best, fit(fine, other.candidate, other.u, other.v), key=lambda f: f.cost)
