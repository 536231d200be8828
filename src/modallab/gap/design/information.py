"""What records that have not been made would say between explanations, each linear about its own fit.

Where explanation A is true, its fit's numbers are drawn from what the records so far leave open, the new records follow
with their noise, and every explanation is fitted again to all of them. Half the difference of the squares is the
logarithm of the likelihoods' ratio; its mean is what an experiment is expected to tell (Box and Hill, Technometrics 9
(1967), 57; Lindley, Ann. Math. Stat. 27 (1956), 986). Of the records only products of slopes and answers count: of
several experiments these add up.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.design.explanations import Explanation
from modallab.gap.inference.evidence import (
    RecordsFloor,
    likelihood,
    probabilities_of,
    records_floor,
    squares_of_priors_and_clock,
)
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.model.fit import Fit, cost_of
from modallab.gap.model.minimise import jacobian

DRAWS = 100
"""New records that are drawn for each explanation."""
OPEN, OPEN_PLACE = 0.3, 0.02
"""Coordinates of an effect that the records leave open are drawn this far from the fit: beyond, slopes say nothing."""
FAR = 30.0
"""Times as far as that a fit by slopes goes, about: at the end of its range a number has none."""
ALONE = 0.95
"""Probability from which an explanation counts as the only one left."""
SEED = 20261125


@dataclass(frozen=True, eq=False, slots=True)
class RivalExplanations:
    """Explanations, linear about their fits to the records that are there.

    Attributes:
        listed: the explanations.
        numbers: of each, which columns of `predicted_differences` are its own.
        starts: (numbers, numbers) curvature and (numbers,) slope of each one's squares.
        floor: what their squares are compared with.
    """

    listed: tuple[Explanation, ...]
    numbers: tuple[slice, ...]
    starts: tuple[tuple[Real, Real], ...]
    floor: RecordsFloor

    @classmethod
    def of(cls, listed: Sequence[Explanation]) -> Self:
        """At least two explanations, fitted to the same records."""
        ends = np.cumsum([0, *(r.fit.u.size for r in listed)]).tolist()
        numbers = tuple(slice(a, b) for a, b in pairwise(ends))
        floor = records_floor(min((r.fit for r in listed), key=cost_of))
        return cls(tuple(listed), numbers, tuple(_coordinates_of_fit(r.fit) for r in listed), floor)


@dataclass(frozen=True, eq=False, slots=True)
class ExpectedOutcome:
    """What an experiment is expected to bring.

    Attributes:
        right: mean probability of the explanation that is true, once the experiment is made.
        alone: how often it is the only one left.
        ratio: (true, other) mean logarithm of the likelihoods' ratio on all records.
        chances: (true,) probabilities so far, by the fits to what is there.
    """

    right: float
    alone: float
    ratio: Real
    chances: Real

    @property
    def log_likelihood_ratio(self) -> float:
        """Logarithm of the likelihoods' ratio of the true explanation to the one nearest to it, in the mean."""
        others = self.ratio + np.diag(np.full(len(self.ratio), np.inf))
        return float(self.chances @ np.min(others, axis=1))


def _coordinates_of_fit(fit: Fit) -> tuple[Real, Real]:
    J, n = jacobian(fit.problem, fit.u, fit.residual), fit.problem.free.size
    _, slope, curvature = fit.problem.priors(fit.u)
    normal, gradient = J.T @ J, J.T @ fit.residual
    normal[np.diag_indices(len(normal))] += np.concatenate([curvature, (FAR * _widest_draws(fit)) ** -2])
    gradient[:n] += slope
    return normal, gradient


def predicted_differences(rivals: RivalExplanations, data: Reduced) -> Real:
    """(residuals, all numbers + explanations) slopes of each explanation's answers, and its answers less the first's.

    In noise units; what the records so far say of the generator's clock does not count twice.
    """
    slopes: list[Real] = []
    left: list[Real] = []
    for rival in rivals.listed:
        problem = replace(rival.fit.problem, data=data)
        left.append(problem.residual(rival.fit.u))
        slopes.append(-jacobian(problem, rival.fit.u, left[-1]))
    found = np.hstack([*slopes, np.array([left[0] - r for r in left]).T])
    known = data.sines is not None and rivals.listed[0].fit.problem.data.sines is not None
    return found[:-1] if known else found


def expected_outcome(rivals: RivalExplanations, gram: Real, nonlinear: Real | None = None) -> ExpectedOutcome:
    """What an experiment is expected to bring.

    Args:
        rivals: the explanations.
        gram: products of the experiment's columns.
        nonlinear: (true, other) what full fits leave above linear ones, in squares; None for none.
    """
    rng = np.random.default_rng(SEED)
    values, vectors = np.linalg.eigh(gram)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    size = len(rivals.listed)
    right, alone, ratio = np.zeros(size), np.zeros(size), np.zeros((size, size))
    for true in range(size):
        noise = rng.standard_normal((DRAWS, len(gram))) @ root.T
        costs = _costs_of_rivals(rivals, gram, true, _draw_numbers(rivals, true, rng), noise)
        costs += 0.0 if nonlinear is None else nonlinear[true]
        after = probabilities_of_rivals(rivals, costs)[:, true]
        right[true], alone[true] = np.mean(after), np.mean(after >= ALONE)
        ratio[true] = np.mean(costs - costs[:, [true]], axis=0) / 2
    chances = probabilities_of_rivals(rivals, np.array([r.fit.cost for r in rivals.listed]))
    return ExpectedOutcome(float(chances @ right), float(chances @ alone), ratio, chances)


def residuals_after_refit(rivals: RivalExplanations, gram: Real, true: int) -> list[tuple[float, Real]]:
    """What each explanation leaves by slopes of the answers of one and of the records before, and its numbers then."""
    answers = np.zeros((1, len(gram)))
    answers[0, len(gram) - len(rivals.listed) + true] = 1
    found = [_refit_rival(rivals, gram, k, answers, np.zeros((1, len(gram)))) for k in range(len(rivals.listed))]
    return [(float(cost[0]), r.fit.u + step[0]) for r, (cost, step) in zip(rivals.listed, found, strict=True)]


def residuals_between_explanations(rivals: RivalExplanations, columns: Real) -> Real:
    """(residuals,) what the second explanation, fitted again, leaves of the answers of the first, in noise units."""
    own, first = rivals.numbers[1], columns.shape[1] - len(rivals.listed)
    slopes, off = columns[:, own], -columns[:, first + 1]
    normal, gradient = rivals.starts[1]
    step: Real = np.linalg.solve(normal + slopes.T @ slopes, slopes.T @ off - gradient).astype(np.float64)
    return off - slopes @ step


def probabilities_of_rivals(rivals: RivalExplanations, costs: Real) -> Real:
    """(..., explanations) probabilities, as a diagnosis of all records would give them, of squares left of all."""
    fits = [r.fit for r in rivals.listed]
    deviations = np.array([squares_of_priors_and_clock(f) for f in fits])
    effects = np.array([len(f.problem.candidates) for f in fits])
    squares = costs - deviations
    squares += rivals.floor.least - np.min(squares, axis=-1, keepdims=True)
    return probabilities_of(likelihood(squares, rivals.floor) + deviations + DEFAULT.effect_price * effects)


def _widest_draws(fit: Fit) -> Real:
    """(numbers of its effects,) how far each is drawn from the fit at most, about."""
    return np.array([OPEN_PLACE if s.name == "x" else OPEN for c in fit.problem.candidates for s in c.slots])


def _draw_numbers(rivals: RivalExplanations, true: int, rng: np.random.Generator) -> Real:
    """(draws, numbers) what the records so far leave open of an explanation's numbers."""
    fit, normal = rivals.listed[true].fit, rivals.starts[true][0].copy()
    own = np.arange(fit.problem.free.size, len(normal))
    normal[own, own] += _widest_draws(fit) ** -2
    z = rng.standard_normal((len(normal), DRAWS))
    drawn: Real = np.linalg.solve(np.linalg.cholesky(normal).T, z).T.astype(np.float64)
    return drawn


def _costs_of_rivals(rivals: RivalExplanations, gram: Real, true: int, drawn: Real, noise: Real) -> Real:
    """(draws, explanations) squares that each leaves of all records, less those of the new noise alone."""
    answers = np.zeros((len(drawn), len(gram)))
    answers[:, rivals.numbers[true]] = drawn
    answers[:, len(gram) - len(rivals.listed) + true] += 1
    return np.array([_refit_rival(rivals, gram, k, answers, noise)[0] for k in range(len(rivals.listed))]).T


def _refit_rival(rivals: RivalExplanations, gram: Real, k: int, answers: Real, noise: Real) -> tuple[Real, Real]:
    """(draws,) squares that an explanation leaves, fitted again, and (draws, numbers) how far its numbers go.

    Args:
        rivals: the explanations.
        gram: products of the experiment's columns.
        k: which explanation.
        answers: (draws, columns) the new records, as sums of columns.
        noise: (draws, columns) products of their noise with the columns.
    """
    own, (normal, gradient) = rivals.numbers[k], rivals.starts[k]
    less = answers.copy()
    less[:, len(gram) - len(rivals.listed) + k] -= 1
    along = less @ gram + noise
    slope = along[:, own] - gradient
    step: Real = np.linalg.solve(normal + gram[own, own], slope.T).T.astype(np.float64)
    return rivals.listed[k].fit.cost + np.sum(less * (along + noise), axis=1) - np.sum(slope * step, axis=1), step
