"""By how much two tests of a structure differ though nothing was changed: a ladder of scales, and the likely one on it.

Lines, what goes along whole FRFs, and the structure have one scale each. The usual ladder stands on what is usual, and
goes down from there; what has no name stands above it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from modallab.gap.modal.compared import Compared
from modallab.gap.modal.fitting import Fitted, fit
from modallab.gap.modal.linear import Linear

USUAL = (1.0, 0.25, 0.0625)
"""ScaleLadder of what two tests of a structure differ by, over what is usual, at most."""
UNUSUAL = (4.0, 16.0, 64.0)
"""ScaleLadder of what has no name."""
TURNS = 2
"""Times that scales are inferred, and numbers fitted at them."""
SUSPECTS = 2
"""Channels of which it is asked whether they do something else."""

Rung = tuple[Compared, float]
"""A comparison with its lines and shapes at some scale, and the scale of the structure."""


@dataclass(frozen=True, eq=False, slots=True)
class ScaleLadder:
    """The scales of one comparison.

    Attributes:
        of: the comparison at what is usual.
        even: scale of lines, and of shapes -> the comparison at them.
    """

    of: Compared
    even: Mapping[tuple[float, float], Compared]

    @classmethod
    def about(cls, c: Compared) -> "ScaleLadder":
        """Of lines and shapes they are inferred where both FRFs were measured: what models leave is no sample."""
        steps = (1.0,) if c.frfs is None else USUAL
        return cls(c, {(a, b): c.scaled(a, b) for a, b in product(steps, steps)})

    @property
    def usual(self) -> list[Rung]:
        """At most what is usual."""
        return list(product(self.even.values(), USUAL))

    def nameless(self, base: Fitted, least: Fitted) -> dict[str, list[Rung]]:
        """Where the structure, everything, or a channel differs by more than is usual.

        Args:
            base: fitted without a change.
            least: the explanation at whose scale all that is not unusual is.
        """
        lines, shapes = next((key for key, own in self.even.items() if own is least.free.of), (1.0, 1.0))
        missed, names = np.sqrt(np.mean(base.missed**2, axis=(0, 2))), self.of.model.outputs
        found: dict[str, list[Rung]] = {"structure": list(product(self.even.values(), UNUSUAL))}
        found["everything"] = [(self.of.scaled(a, x), x) for x in UNUSUAL for a in (lines, x)]
        for o in np.argsort(-missed)[:SUSPECTS]:
            there = np.arange(missed.size)[:, None] == o
            ladder = ((np.where(there, a, lines), np.where(there, x, shapes)) for x in UNUSUAL for a in (lines, x))
            found[names[int(o)]] = [(self.of.scaled(*each), least.free.wide) for each in ladder]
        return found


def estimated(fitted: Fitted, rungs: Sequence[Rung]) -> Fitted:
    """It with its evidence at its most probable scale, which its linearisation tells."""
    return replace(fitted, evidence=_likeliest(fitted, rungs)[0])


def settled(fitted: Fitted, rungs: Sequence[Rung]) -> Fitted:
    """It fitted there."""
    for _ in range(TURNS):
        fitted = _at(fitted, *_likeliest(fitted, rungs)[1:])
    return fitted


def _likeliest(fitted: Fitted, rungs: Sequence[Rung]) -> tuple[float, Compared, float]:
    linear, weighed = Linear.about(fitted), {}
    for own, _ in rungs:
        if id(own) not in weighed:
            weighed[id(own)] = linear.weighed(own.weights)
    every = ((weighed[id(own)].evidence(wide), own, wide) for own, wide in rungs)
    return min(every, key=lambda e: e[0])


def _at(fitted: Fitted, there: Compared, wide: float) -> Fitted:
    free = replace(fitted.free, of=there, wide=wide)
    # The numbers stay what they are, in other deviations.
    before, after = fitted.free.deviations, free.deviations
    u = fitted.u * np.divide(before, after, out=np.ones_like(after), where=after > 0)
    return fit(free, fitted.candidate, u, fitted.v)
