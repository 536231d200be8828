"""An effect that is another one but for tolerances goes by that one's name: a gain of -0.99 is a wrong sign.

Beside an effect that is not yet named its number is off by more than its tolerance, and round by round it stays.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from modallab.gap.model.candidates import of_channel
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.minimise import minimise
from modallab.gap.search.fitting import Bench
from modallab.gap.search.round import ALIKE
from modallab.gap.search.worth import ABOVE
from modallab.twin.candidate import Candidate
from modallab.twin.effects import search_of


def simplest(bench: Bench, fit: Fit) -> Fit:
    """A fit whose effects are named by as few numbers as leave about as little.

    Args:
        bench: what was searched.
        fit: what was found there.
    """
    for which in range(len(fit.problem.candidates)):
        for other in _fewer(bench, fit, which):
            again = _exchanged(fit, which, other)
            if again.gap <= bench.flat or again.cost < ALIKE * fit.cost:
                fit = again
                break
    return fit


def _fewer(bench: Bench, fit: Fit, which: int) -> Iterator[Candidate]:
    """Effects of fewer numbers on the same channel that an effect of a fit is but for tolerances."""
    own, effect = fit.problem.candidates[which], fit.effects[which]
    channel = dict(own.place).get("channel")
    if not isinstance(channel, int):
        return
    far = search_of(own.effect).deviations_from
    for other in of_channel(bench.data.rig, channel):
        fewer = len(other.slots) < len(own.slots) and bench.allowed(other.effect)
        if fewer and far(effect, other.effect, bench.data.rig) <= ABOVE:
            yield other


def _exchanged(fit: Fit, which: int, other: Candidate) -> Fit:
    """The fit with another effect in the place of one, whose numbers begin as they may."""
    candidates = list(fit.problem.candidates)
    at = fit.problem.free.size + sum(len(c.slots) for c in candidates[:which])
    own = [s.coordinate(s.starts[0]) for s in other.slots]
    u = np.concatenate([fit.u[:at], own, fit.u[at + len(candidates[which].slots) :]])
    candidates[which] = other
    problem: Problem = replace(fit.problem, candidates=tuple(candidates))
    return minimise(problem, u, 8, 1e-3)
