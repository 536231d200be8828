"""What the records say for an explanation, where the twin itself is a little wrong.

The records hold thousands of numbers, but a model is wrong in few ways: in the frequency, the damping and the size of
each of its modes. So what an explanation leaves above the noise, X squares, counts as that of nu = 3 x modes numbers
with one variance. Before the records that variance is expected to be s2: a model is off by the smallest discrepancy of
the settings, and an effect by the share of what it does that its model declares as inexact. That expectation counts as
one number. Then -2 log likelihood is (nu + 1) ln(1 + X / (nu + s2)), but for a constant (a variance with a
scaled inverse chi-square prior: Gelman et al., Bayesian Data Analysis, 2013, ch. 2; model discrepancy: Kennedy and
O'Hagan, J. R. Stat. Soc. B 63, 2001, 425). Far above s2 only the ratio of two X counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.model.fit import Fit, all_rows
from modallab.gap.model.forward import forward
from modallab.gap.search.fitting import without_effect
from modallab.twin.effects import search_of

NUMBERS_OF_MODE = 3
"""In which a mode of the model may be wrong: frequency, damping ratio, size."""


def evidence(fits: Sequence[Fit]) -> Real:
    """(fits,) -2 log evidence of explanations fitted to the same records, but for a constant; smaller is better."""
    before = np.array([prior_of(f) for f in fits])
    squares = np.array([f.cost - f.problem.priors(f.u)[0] for f in fits])
    return before + likelihood(squares, RecordsFloor.of(fits[int(np.argmin(squares))]))


def prior_of(fit: Fit) -> float:
    """-2 log prior of an explanation: of its beam and assembly, and the price of each effect."""
    return fit.problem.priors(fit.u)[0] + DEFAULT.effect_price * len(fit.problem.candidates)


@dataclass(frozen=True, slots=True)
class RecordsFloor:
    """What the squares of explanations are compared with.

    Attributes:
        above: squares above the noise that the best explanation leaves.
        expected: squares of a number in which the model may be wrong, noise included.
        numbers: of these.
    """

    above: float
    expected: float
    numbers: int

    @classmethod
    def of(cls, best: Fit) -> Self:
        """By the best explanation."""
        numbers = NUMBERS_OF_MODE * best.problem.free.modes
        discrepancy = _squares_of_discrepancy(best) + _squares_of_inexact_effects(best)
        above = max(float(best.residual @ best.residual) - np.count_nonzero(best.residual), 0.0)
        return cls(above, 1 + discrepancy / numbers, numbers)


def likelihood(squares: Real, floor: RecordsFloor) -> Real:
    """(..., explanations) -2 log likelihood of explanations.

    Args:
        squares: (..., explanations) of the records' residuals, in noise units.
        floor: what they are compared with.
    """
    above = floor.above + squares - np.min(squares, axis=-1, keepdims=True)
    return (floor.numbers + 1) * np.log1p(above / (floor.numbers + floor.expected))


def _squares_of_discrepancy(fit: Fit) -> float:
    """Squares that the same bench leaves with frequencies, damping ratios and sizes off by the smallest discrepancy."""
    share, data = DEFAULT.smallest_scale, fit.problem.data
    twin = replace(fit.problem.twin(fit.u), element=None)
    beam, answers = twin.structure, forward(twin, data)
    stiffer = replace(beam, youngs_modulus_pa=beam.youngs_modulus_pa * (1 + 2 * DEFAULT.frequency_share * share))
    damped = replace(beam, zeta=beam.zeta * (1 + DEFAULT.damping_share * share))
    moved = [forward(replace(twin, structure=b), data) for b in (stiffer, damped)]
    sizes = [(1 + share) * y for y in answers]
    return sum(_squares(data, m, answers) for m in (*moved, sizes))


def _squares(data: Reduced, moved: Sequence[Complex], answers: Sequence[Complex]) -> float:
    """Of what is between two answers, in noise units."""
    parts = (rows.whiten(m - y) for rows, m, y in zip(all_rows(data), moved, answers, strict=True))
    return float(sum(np.sum(np.abs(p) ** 2) for p in parts))


def _squares_of_inexact_effects(fit: Fit) -> float:
    """Squares that remain of what the effects do, by what each declares of its own model."""
    found = 0.0
    for which, candidate in enumerate(fit.problem.candidates):
        inexact = search_of(candidate.effect).inexact
        if inexact:
            problem, u = without_effect(fit.problem, fit.u, which)
            found += inexact**2 * float(np.sum((problem.residual(u) - fit.residual) ** 2))
    return found


def probabilities_of(minus_two_logs: Real) -> Real:
    """(..., explanations) probabilities of explanations, one of which is true, from their -2 log evidence."""
    weights = np.exp(-0.5 * (minus_two_logs - np.min(minus_two_logs, axis=-1, keepdims=True)))
    return weights / np.sum(weights, axis=-1, keepdims=True)
