"""What the records say for an explanation, where the twin itself is a little wrong.

The records hold thousands of numbers, but a model is wrong in few ways: in the frequency, the damping and the size of
each of its modes. So what an explanation leaves above the noise, X squares, counts as that of nu = 3 x modes numbers
with one variance. Before the records that variance is expected to be s2: a model is off by the expected error of
the settings, and an effect by the share of what it does that its model declares as inexact. That expectation counts as
one number. Then -2 log likelihood is (nu + 1) ln(1 + X / (nu + s2)), but for a constant (a variance with a
scaled inverse chi-square prior: Gelman et al., Bayesian Data Analysis, 2013, ch. 2; model discrepancy: Kennedy and
O'Hagan, J. R. Stat. Soc. B 63, 2001, 425). Far above s2 only the ratio of two X counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.model.fit import Fit
from modallab.gap.model.forward import forward
from modallab.twin.effects import search_of

NUMBERS_OF_MODE = 3
"""In which a mode of the model may be wrong: frequency, damping ratio, size."""
WEIGHTS = np.geomspace(1.0, 1e-6, 13)
"""Weights of the records' squares that are tried beside those of the tolerances."""
TINY = 1e-12
"""Curvature of a number that neither records nor tolerances determine."""


def evidence(fits: Sequence[Fit]) -> Real:
    """(fits,) -2 log evidence of explanations fitted to the same records, but for a constant; smaller is better."""
    balanced = [balanced_squares(f) for f in fits]
    records = np.array([squares for squares, _ in balanced])
    floor = records_floor(fits[int(np.argmin(records[:, 0]))])
    effects = np.array([len(f.problem.candidates) for f in fits])
    totals = likelihood(records, floor) + np.array([deviations for _, deviations in balanced])
    return np.min(totals, axis=1) + DEFAULT.effect_price * effects


def evidence_without_name(best: Fit) -> float:
    """-2 log evidence that the cause has no name: it changes each mode in its own way, at the price of an effect.

    Args:
        best: an explanation of the same records.
    """
    return DEFAULT.effect_price * best.problem.free.modes


def explains(fit: Fit) -> bool:
    """Whether the effects of a fit are more probable than a cause without a name."""
    return bool(fit.problem.candidates) and bool(evidence([fit])[0] < evidence_without_name(fit))


def more_probable(fit: Fit, than: Fit) -> bool:
    """Whether an explanation is more probable than another of the same records."""
    own, other = evidence([fit, than])
    return bool(own < other)


def balanced_squares(fit: Fit) -> tuple[Real, Real]:
    """(weights,) squares of the records, and of tolerances and clock, as the records count for less and less.

    A fit trades one for the other at par. Where the model is wrong the records count for less, and no bench would have
    to be that far off its tolerances: to first order about the fit.
    """
    clock, (_, pull, _) = squares_of_clock(fit), fit.problem.priors(fit.u)
    curvature, steps = _steps_back(fit)
    more = np.einsum("wi,ij,wj->w", steps, curvature, steps) - 2 * steps[:, : len(pull)] @ pull
    off = np.array([fit.problem.priors(fit.u + step)[0] for step in steps])
    return fit.cost - squares_of_priors_and_clock(fit) + np.maximum(more, 0.0), off + clock


def _steps_back(fit: Fit) -> tuple[Real, Real]:
    """(u, u) curvature of the records' squares, and (weights, u) where a fit goes if they count for less."""
    _, pull, stiffness = fit.problem.priors(fit.u)
    rest = np.zeros(len(fit.u) - len(pull))
    tolerances = np.diag(np.concatenate([stiffness, rest]))
    curvature = fit.normal - tolerances
    held = WEIGHTS[:, None, None] * curvature + tolerances + TINY * np.eye(len(fit.u))
    back = -(1 - WEIGHTS[:, None]) * np.concatenate([pull, rest])
    steps: Real = np.linalg.solve(held, back[..., None])[..., 0].astype(np.float64)
    return curvature, steps


def squares_of_clock(fit: Fit) -> float:
    """What the generator's lines say against the clock of a fit: no error of the beam's model makes them."""
    return float(fit.residual[-1] ** 2) if fit.problem.data.sines is not None else 0.0


def squares_of_priors_and_clock(fit: Fit) -> float:
    """Squares of a fit's cost that are none of the records': of the tolerances' deviations, and of the clock."""
    return fit.problem.priors(fit.u)[0] + squares_of_clock(fit)


@dataclass(frozen=True, slots=True)
class RecordsFloor:
    """What the squares of explanations are compared with.

    Attributes:
        least: squares that the best explanation leaves.
        above: of these above the noise.
        expected: squares of a number in which the model may be wrong, noise included.
        numbers: of these.
    """

    least: float
    above: float
    expected: float
    numbers: int

    @property
    def variance(self) -> float:
        """Variance of each number in which the model may be wrong, in units of the noise's variance."""
        return (self.numbers + self.expected + self.above) / (self.numbers + 1)


@lru_cache(maxsize=16)
def records_floor(best: Fit) -> RecordsFloor:
    """What explanations are compared with, by the best of them; kept, as a law steps all records in time for it."""
    numbers = NUMBERS_OF_MODE * best.problem.free.modes
    discrepancy = _squares_of_discrepancy(best) + _squares_of_inexact_effects(best)
    least = float(best.residual @ best.residual) - squares_of_clock(best)
    above = max(least - np.count_nonzero(best.residual), 0.0)
    return RecordsFloor(least, above, 1 + discrepancy / numbers, numbers)


def likelihood(squares: Real, floor: RecordsFloor) -> Real:
    """-2 log likelihood of explanations that leave these squares, in noise units; in any shape."""
    above = floor.above + squares - floor.least
    return (floor.numbers + 1) * np.log1p(above / (floor.numbers + floor.expected))


def _squares_of_discrepancy(fit: Fit) -> float:
    """Squares that the same bench leaves with frequencies, damping ratios and sizes off by the expected error."""
    share, data = DEFAULT.expected_error, fit.problem.data
    twin = replace(fit.problem.twin(fit.u), element=None)
    beam, answers = twin.structure, forward(twin, data)
    stiffer = replace(beam, youngs_modulus_pa=beam.youngs_modulus_pa * (1 + 2 * DEFAULT.frequency_share * share))
    damped = replace(beam, zeta=beam.zeta * (1 + DEFAULT.damping_share * share))
    moved = [forward(replace(twin, structure=b), data) for b in (stiffer, damped)]
    sizes = [(1 + share) * y for y in answers]
    here, *there = (fit.problem.residual_of(twin, each) for each in (answers, *moved, sizes))
    return float(sum(np.sum((r - here) ** 2) for r in there))


def _squares_of_inexact_effects(fit: Fit) -> float:
    """Squares that the same explanation leaves with each effect smaller by what it declares of its own model."""
    first, found = fit.problem.free.size, 0.0
    for candidate in fit.problem.candidates:
        own, inexact = np.s_[first : first + len(candidate.slots)], search_of(candidate.effect).inexact
        if inexact:
            u = fit.u.copy()
            u[own] = candidate.with_signature(u[own], 1 - inexact)
            found += float(np.sum((fit.problem.residual(u) - fit.residual) ** 2))
        first = own.stop
    return found


def probabilities_of(minus_two_logs: Real) -> Real:
    """(..., explanations) probabilities of explanations, one of which is true, from their -2 log evidence."""
    weights = np.exp(-0.5 * (minus_two_logs - np.min(minus_two_logs, axis=-1, keepdims=True)))
    return weights / np.sum(weights, axis=-1, keepdims=True)
