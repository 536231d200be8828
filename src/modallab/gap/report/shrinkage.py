"""How far the gap shrinks on held-out records.

Source: Percentile interval of the bootstrap: Efron, Ann. Stat. 7 (1979), 1; Efron and Tibshirani, An Introduction to
the Bootstrap, 1993, ch. 13.
"""

import numpy as np

from modallab.core.diagnosis import Shrinkage
from modallab.gap.report.measure import SquaredResiduals

DRAWS = 400
BARE = 0.02
"""Excess above the floor below which there is nothing to shrink."""


def closed_share(before: float, after: float) -> float:
    """Share of the reducible gap that is closed: 1 - (after^2 - 1) / (before^2 - 1)."""
    return 1 - (after**2 - 1) / (before**2 - 1)


def shrinkage_with_interval(
    held_out: list[str],
    before: SquaredResiduals,
    after: SquaredResiduals,
    rivals: dict[str, float],
    rng: np.random.Generator,
) -> Shrinkage:
    """The shrinkage with its 95 % interval, by bootstrap over channels of records.

    Args:
        held_out: names of the records.
        before: squares of the twin without effects, in noise units squared, one entry a channel of a record.
        after: the same with the effects found, entry by entry.
        rivals: share closed by the best other explanation, by its effects.
        rng: draws the entries with replacement.
    """
    if before.gap**2 - 1 < BARE:
        return Shrinkage(
            held_out=held_out, before=before.gap, after=after.gap, closed=None, interval=None, rival=rivals
        )
    draws = rng.integers(0, len(before.total), size=(DRAWS, len(before.total)))
    count = np.sum(before.count[draws], axis=1)
    g0, g1 = (np.sum(s.total[draws], axis=1) / count for s in (before, after))
    # A draw without any of the gap says nothing about how much of it is closed.
    ok = g0 - 1 > 0.05 * (before.gap**2 - 1)
    values = 1 - (g1[ok] - 1) / (g0[ok] - 1)
    low, high = np.quantile(values, [0.025, 0.975]) if len(values) > 20 else (-np.inf, 1.0)
    share = closed_share(before.gap, after.gap)
    return Shrinkage(
        held_out=held_out,
        before=before.gap,
        after=after.gap,
        closed=share,
        interval=(min(float(low), share), max(float(high), share)),
        rival=rivals,
    )
