"""What the records say for an explanation, where the twin itself is a little wrong.

The records hold thousands of numbers, but a model is wrong in few ways: in the frequency, the damping and the size of
each of its modes. So what an explanation leaves above the noise, X squares, counts as that of nu = 3 x modes numbers
with one unknown variance. Its most probable value given, -2 log of the likelihood is nu ln(1 + X / nu), but for a
constant (profile likelihood of a variance: Seber and Wild, Nonlinear Regression, 1989; model discrepancy: Kennedy and
O'Hagan, J. R. Stat. Soc. B 63, 2001, 425). Near the noise that is X itself, as under noise alone; far above it only the
ratio of two X counts.
"""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.model.fit import Fit, cost_of
from modallab.gap.search.fitting import excess

NUMBERS_OF_MODE = 3
"""In which a mode of the model may be wrong: frequency, damping ratio, size."""


def evidence(fits: Sequence[Fit]) -> Real:
    """(fits,) -2 log evidence of explanations fitted to the same records, but for a constant; smaller is better."""
    best = min(fits, key=cost_of)
    above = excess(best) * np.count_nonzero(best.residual)
    costs, effects = np.array([[f.cost, len(f.problem.candidates)] for f in fits]).T
    return evidence_of_costs(costs, effects, above, best.problem.free.modes)


def evidence_of_costs(costs: Real, effects: Real, above: float, modes: int) -> Real:
    """(..., explanations) -2 log evidence.

    Args:
        costs: (..., explanations) squares that each leaves.
        effects: (explanations,) how many each has.
        above: squares above the noise that the best of them leaves.
        modes: of the model, in the band.
    """
    numbers = NUMBERS_OF_MODE * modes
    squares = above + costs - np.min(costs, axis=-1, keepdims=True)
    return numbers * np.log1p(squares / numbers) + DEFAULT.effect_price * effects


def probabilities_of(minus_two_logs: Real) -> Real:
    """(..., explanations) probabilities of explanations, one of which is true, from their -2 log evidence."""
    weights = np.exp(-0.5 * (minus_two_logs - np.min(minus_two_logs, axis=-1, keepdims=True)))
    return weights / np.sum(weights, axis=-1, keepdims=True)
