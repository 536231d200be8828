"""By how much two tests of a structure differ: as is usual, or by more, which has no name.

Lines, what goes along whole FRFs, and the structure have one scale each, 1 for what is usual. That of the structure may
be less, which its modes show. FRFs do not show it of the others: what a sensor or a hit is off by is alike in all FRFs
of its place, so that FRFs which agree are no sample of many.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.fitting import FittedExplanation, fit
from modallab.gap.modal.free import SCALES
from modallab.gap.modal.linear import Linear, WeightedSquares

USUAL = (1.0, 0.25, 0.0625)
"""Scales of the structure in two tests of it, at most what is usual."""
UNUSUAL = (4.0, 16.0, 64.0)
"""Scales of what has no name."""
NOISES = (1.0, 2.0, 4.0)
"""Scales of the noise of measured FRFs: of what models leave between the lines no more than the order is known."""
TURNS = 2
"""Times that scales are inferred, and numbers fitted at them."""
SUSPECTS = 2
"""Channels, and driven points, of which it is asked whether they do something else."""

Rung = tuple[Compared, Real | float]
"""A comparison with its lines and shapes at some scale, and the scale of the structure."""


def usual(c: Compared) -> list[Rung]:
    """A comparison of two tests that differ as is usual."""
    return [(one, x) for one in with_noises(c) for x in USUAL]


def with_noises(c: Compared) -> list[Compared]:
    """A comparison at each scale of the noise; alone where no FRFs were measured."""
    return [c] if c.noise is None else [c.noisier(x) for x in NOISES]


def nameless(fitted: FittedExplanation) -> dict[str, FittedExplanation]:
    """It where the structure in some of its numbers, or everything, differs by more than is usual besides."""
    c = fitted.free.of
    everything = [(c.scaled(a, x), x) for x in UNUSUAL for a in (1.0, x)]
    return {"structure": departed(fitted, UNUSUAL, least=1), "everything": settled(fitted, everything)}


def unusual_rungs(c: Compared, there: NDArray[np.bool_], wide: Real | float) -> list[Rung]:
    """Rungs on which some FRFs, of a channel (outputs, 1) or a driven point (1, inputs), differ by more than usual."""
    each = ((np.where(there, a, 1.0), np.where(there, x, 1.0)) for x in UNUSUAL for a in (1.0, x))
    return [(c.scaled(*scales), wide) for scales in each]


def estimated(fitted: FittedExplanation, rungs: Sequence[Rung]) -> FittedExplanation:
    """It with its evidence at its most probable scale, which its linearisation tells."""
    return replace(fitted, evidence=_likeliest(fitted, rungs)[0])


def settled(fitted: FittedExplanation, rungs: Sequence[Rung]) -> FittedExplanation:
    """It fitted there."""
    for _ in range(TURNS):
        fitted = _at(fitted, *_likeliest(fitted, rungs)[1:])
    return fitted


def departed(fitted: FittedExplanation, scales: Sequence[float], least: int = 0) -> FittedExplanation:
    """It where some numbers of the structure have larger scales than others: as few as the evidence says, or least."""
    noises = with_noises(fitted.free.of)
    for _ in range(TURNS):
        linear, each = Linear.about(fitted), list[tuple[float, Compared, Real]]()
        for own in noises:
            weighed = linear.weighed(own.weights)
            wide = (_scales_of_their_own(weighed, usual, scales, least) for usual in USUAL)
            each += [(weighed.evidence(w), own, w) for w in wide]
        fitted = _at(fitted, *min(each, key=lambda e: e[0])[1:])
    return fitted


def _scales_of_their_own(weighed: WeightedSquares, usual: float, scales: Sequence[float], least: int) -> Real:
    """(numbers of the structure,) the scale of each, the usual one of all others."""
    larger = [scale for scale in scales if scale > usual]
    wide = np.full(weighed.of.free.structure_size, usual)
    while larger:
        # One that has departed already has its scale.
        gained = np.where(wide[:, None] > usual, np.inf, weighed.gained(wide, larger))
        n, k = divmod(int(np.argmin(gained)), len(larger))
        if gained[n, k] + 2 * np.log(SCALES * wide.size) >= 0 and np.count_nonzero(wide > usual) >= least:
            break
        wide[n] = larger[k]
    return wide


def _likeliest(fitted: FittedExplanation, rungs: Sequence[Rung]) -> tuple[float, Compared, Real | float]:
    linear, weighed = Linear.about(fitted), {}
    for own, _ in rungs:
        if id(own) not in weighed:
            weighed[id(own)] = linear.weighed(own.weights)
    every = ((weighed[id(own)].evidence(wide), own, wide) for own, wide in rungs)
    return min(every, key=lambda e: e[0])


def _at(fitted: FittedExplanation, there: Compared, wide: Real | float) -> FittedExplanation:
    free = replace(fitted.free, of=there, wide=wide)
    # The numbers stay what they are, in other deviations.
    before, after = fitted.free.deviations, free.deviations
    u = fitted.u * np.divide(before, after, out=np.ones_like(after), where=after > 0)
    return fit(free, fitted.candidate, u, fitted.v)
