"""The most probable numbers of an explanation, and its evidence.

Levenberg-Marquardt on rows weighted as Student's t asks (iteratively reweighted least squares), the scales of the
discrepancy set to their most probable values in turn; the evidence by Laplace's approximation (MacKay, Neural
Computation 4, 1992, 415).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.effects import kind_of
from modallab.core.rig import Rig
from modallab.gap.inference.discrepancy import Levels
from modallab.gap.inference.view import STEP, Match, RowModel
from modallab.gap.model.fit import Problem
from modallab.twin.candidate import CandidateEffect, FreeNumber

Array = NDArray[np.float64]

Key = tuple[tuple[str, str], ...]
"""Effects and fixed places, sorted: what tells one explanation from another."""

NEAREST_ROOT = 0.02
"""Place nearest to the clamp, as a share of the length: a beam hardly moves there."""
LONGEST = 4.0
"""Longest step of a number, in deviations of its prior or in coordinates of an effect."""
SAME_SLOPES = 3
"""Steps that one evaluation of the slopes serves, at most."""


def key_of(candidates: tuple[CandidateEffect, ...]) -> Key:
    """The effects and fixed places of candidates."""
    return tuple(sorted((c.effect, str(c.place)) for c in candidates))


@dataclass(frozen=True, eq=False, slots=True)
class Posterior:
    """An explanation at its most probable numbers, as far as it was fitted.

    Attributes:
        problem: what was fitted.
        u: (u,) the numbers.
        levels: (groups,) index of the scale of each group.
        cost: -2 log of the posterior density, but for a constant.
        evidence: -2 log of the evidence, but for the same constant; the smaller the better.
        residual: (rows,) measured less predicted.
    """

    problem: Problem
    u: Array
    levels: Levels
    cost: float
    evidence: float
    residual: Array

    @property
    def key(self) -> Key:
        """See `key_of`."""
        return key_of(self.problem.candidates)


@dataclass(frozen=True, eq=False, slots=True)
class _Place:
    """Where a descent stands."""

    u: Array
    predicted: Array
    residual: Array
    levels: Levels
    cost: float


def bounds(candidates: tuple[CandidateEffect, ...], rig: Rig) -> tuple[Array, Array]:
    """(numbers,) lowest and highest coordinates of the effects' numbers: the catalogue's ranges."""
    pairs = [_bounds(c, s, rig) for c in candidates for s in c.slots]
    low, high = np.array(pairs).reshape(-1, 2).T
    return low, high


def _bounds(candidate: CandidateEffect, slot: FreeNumber, rig: Rig) -> tuple[float, float]:
    if slot.name == "x":
        return NEAREST_ROOT, 1.0
    ends = _range_of(candidate, slot, rig)
    low, high = {"plain": (-np.inf, np.inf), "log": (0.0, np.inf), "share": (0.0, 1.0)}[slot.transform]
    allowed = [v for v in (*ends, *slot.starts) if low < v < high and slot.low <= v <= slot.high]
    coordinates = [slot.coordinate(v) for v in allowed]
    return min(coordinates), max(coordinates)


def _range_of(candidate: CandidateEffect, slot: FreeNumber, rig: Rig) -> tuple[float, float]:
    """The catalogue's range; of a number that the catalogue does not list, its own."""
    assert rig.beam is not None
    listed = [p for p in kind_of(candidate.effect).parameters if p.name == slot.name]
    if not listed:
        return slot.low, slot.high
    least, most = listed[0].bounds(rig.beam)
    either = listed[0].signed or slot.transform == "plain"
    return (slot.none - most, slot.none + most) if either else (least, most)


def _widths(problem: Problem, u: Array) -> Array:
    """(numbers,) width of a uniform prior with the density that the prior of an effect's number has at u.

    Places are uniform along the beam, all sizes uniform on their logarithms.
    """
    low, high = bounds(problem.candidates, problem.data.rig)
    widths = high - low
    slots = [s for c in problem.candidates for s in c.slots]
    for k, (slot, own) in enumerate(zip(slots, u[problem.free.size :], strict=True)):
        if slot.transform == "plain" and slot.name != "x":
            away = max(abs(slot.value(float(own)) - slot.none) / slot.scale, 1e-3 * widths[k])
            widths[k] = 2 * away * np.log(1e3)
    return widths


def maximise_posterior(view: RowModel, problem: Problem, u: Array, steps: int, known: Array | None = None) -> Posterior:
    """The explanation after at most so many evaluations of the slopes from u.

    Args:
        view: the rows.
        problem: the explanation.
        u: (u,) its first numbers.
        steps: evaluations of the slopes, at most.
        known: (rows, k) slopes of the first k numbers, where those from elsewhere will do; else they are evaluated.
    """
    n = problem.free.size
    low, high = bounds(problem.candidates, problem.data.rig)
    u = u.copy()
    u[n:] = np.clip(u[n:], low, high)
    here, match = _place_of(view, problem, u)
    damping, normal = 1e-2, np.eye(len(u))
    for _ in range(steps):
        begin = here
        J = _slopes(view, problem, here, match, known)
        here, damping, normal = _line_search(view, problem, match, J, here, damping, (low, high))
        if here is begin:
            break
        here, match = _place_of(view, problem, here.u)
        if begin.cost - here.cost < 0.05 + 1e-3 * np.sqrt(max(1.0, abs(begin.cost))):
            break
    return Posterior(
        problem, here.u, here.levels, here.cost, here.cost + _occam(problem, here.u, normal), here.residual
    )


def _slopes(view: RowModel, problem: Problem, here: _Place, match: Match, known: Array | None) -> Array:
    """(rows, u), those of the first numbers as they are known from elsewhere."""
    if known is None:
        return view.slopes(problem, here.u, match, here.predicted)
    J, k = np.empty((len(here.predicted), len(here.u))), known.shape[1]
    J[:, :k] = known
    for n in range(k, len(here.u)):
        moved = here.u.copy()
        moved[n] += STEP
        J[:, n] = (view.predict(problem.twin(moved), match) - here.predicted) / STEP
    return np.nan_to_num(J)


def _place_of(view: RowModel, problem: Problem, u: Array) -> tuple[_Place, Match]:
    twin = problem.twin(u)
    match = view.matched(twin)
    predicted = view.predict(twin, match)
    residual = view.residual_after(predicted)
    levels = view.objective.levels(residual)
    return _Place(u, predicted, residual, levels, _cost(view, problem, u, residual, levels)), match


def _cost(view: RowModel, problem: Problem, u: Array, residual: Array, levels: Levels) -> float:
    own = u[: problem.free.size]
    return view.objective.cost(residual, levels) + float(own @ own)


def _line_search(
    view: RowModel,
    problem: Problem,
    match: Match,
    J: Array,
    here: _Place,
    damping: float,
    ends: tuple[Array, Array],
) -> tuple[_Place, float, Array]:
    """Where steps with these slopes lead to, the damping of the next, and the curvature there."""
    prior = np.where(np.arange(J.shape[1]) < problem.free.size, 1.0, 0.0)
    normal, begin = np.eye(len(prior)), here
    for turn in range(SAME_SLOPES):
        weights = view.objective.weights(here.residual, here.levels)
        normal = (J * weights[:, None]).T @ J + np.diag(prior)
        gradient = J.T @ (weights * here.residual) - prior * here.u
        before = here
        here, damping = _damped_step(
            view, problem, match, (normal, gradient), here, damping, ends, 8 if turn == 0 else 1
        )
        if here is before or before.cost - here.cost < 0.1 * (begin.cost - here.cost):
            break
    return here, damping, normal


def _damped_step(
    view: RowModel,
    problem: Problem,
    match: Match,
    system: tuple[Array, Array],
    here: _Place,
    damping: float,
    ends: tuple[Array, Array],
    tries: int,
) -> tuple[_Place, float]:
    """The first of ever shorter steps that helps; `here` itself if none does."""
    (normal, gradient), n = system, problem.free.size
    free = np.ones(len(gradient), bool)
    # At an end of its range a number that would go beyond stays: the others must not count on its step.
    free[n:] = ~(((here.u[n:] >= ends[1]) & (gradient[n:] > 0)) | ((here.u[n:] <= ends[0]) & (gradient[n:] < 0)))
    normal, gradient = np.where(np.outer(free, free), normal, np.diag(np.diag(normal))), np.where(free, gradient, 0.0)
    scale = np.maximum(np.diag(normal), 1e-6)
    # What the data leave open must be free to go as far as its prior lets it.
    scale[:n] = np.minimum(scale[:n], 1.0 + 1e-3 * scale[:n])
    for _ in range(tries):
        step = np.linalg.solve(normal + damping * np.diag(scale) + 1e-12 * np.eye(len(scale)), gradient)
        u = here.u + np.clip(step, -LONGEST, LONGEST)
        u[n:] = np.clip(u[n:], *ends)
        predicted = view.predict(problem.twin(u), match)
        residual = view.residual_after(predicted)
        if _cost(view, problem, u, residual, here.levels) < here.cost:
            levels = view.objective.levels(residual)
            cost = _cost(view, problem, u, residual, levels)
            return _Place(u, predicted, residual, levels, cost), max(damping / 10, 1e-9)
        damping *= 10
    return here, damping


def _occam(problem: Problem, u: Array, normal: Array) -> float:
    """-2 log of the share of the prior's volume that the posterior fills."""
    n = problem.free.size
    widths = _widths(problem, u)
    curvature = normal.copy()
    # Of a number that the data leave open its range is known, and no more.
    curvature[np.arange(n, len(u)), np.arange(n, len(u))] += 2 * np.pi / widths**2
    volume = 2 * float(np.sum(np.log(widths / np.sqrt(2 * np.pi))))
    return float(np.linalg.slogdet(curvature)[1]) + volume
