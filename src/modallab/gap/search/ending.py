"""A short fit brought to its end, and begun again where it ended in a bent assembly."""

from dataclasses import replace

import numpy as np

from modallab.gap.model.fit import Fit, Problem, cost_of
from modallab.gap.model.prefit import starts
from modallab.gap.search.fitting import (
    COARSE,
    STRAIGHT,
    Bench,
    annealed,
    at_poles,
    at_rest,
    completed,
    excess,
    finish,
    ordinary,
    short,
)
from modallab.gap.search.screen import Screen
from modallab.twin.effects import model_of

BEGINS = 2
"""Places to begin from which a candidate is fitted once more."""
PROMISING = 0.3
"""Share of the gap below which what an explanation leaves is worth another attempt."""

LAST_DIGIT = 1e-5
"""Share of the squares of the gap below which what is left is the last digit of a model: it is this explanation."""
LITTLE = 3.0
"""The same in squares of noise units, however large the gap is."""
FAR = 30.0
"""Times the floor from which what is left after two beginnings is another effect's."""
ALIKE = 1.3
"""Times what one of them leaves that the other may leave."""


def ended(bench: Bench, fit: Fit, floor: float, before: float) -> Fit:
    """A short fit brought to its end; where its beam has strayed, also from the beam that the poles show.

    What leaves most of the gap `before` is not worth its last digits, and neither is what leaves much wherever it
    begins: another effect is missing.

    Far outside its tolerances a beam hardly answers to its numbers any more, and a fit there never finds its way back.
    """
    there = annealed(bench, fit, floor)
    if excess(there) < min(LAST_DIGIT * (before**2 - 1), LITTLE):
        return completed(bench, there)
    u = at_rest(bench.free, fit.u) if bench.free.deviations else fit.u
    if not is_sound(bench, there) and not np.array_equal(u, fit.u):
        # The fit before had bent beam, gains and deviations to a gap that was not theirs.
        again = annealed(bench, replace(fit, u=u), COARSE / 6)
        if far_alike(bench, there, again):
            return completed(bench, min(there, again, key=cost_of))
        there = min(there, again, key=cost_of)
    if not is_sound(bench, there):
        rest = _from_rest(bench, there) if bench.free.deviations else []
        there = min((there, *_from_frequencies(bench, there), *rest), key=cost_of)
    strayed = bool(np.any(np.abs(there.u[:3]) >= STRAIGHT))
    if there.gap > bench.flat and strayed and len(bench.poles):
        begin = at_poles(bench, there.problem.candidates, there.u[bench.free.size :])
        there = min(there, annealed(bench, begin, COARSE / 6), key=lambda f: f.cost)
    there = completed(bench, there)
    if bench.flat < there.gap < PROMISING * before:
        there = min(there, finish(bench, fit, floor), key=cost_of)
    return there


def far_alike(bench: Bench, fit: Fit, other: Fit) -> bool:
    """Whether two fits of the same from different beginnings both leave much, and about as much."""
    less, more = sorted((fit.gap, other.gap))
    return less > FAR * bench.flat and more < ALIKE * less


def is_sound(bench: Bench, fit: Fit) -> bool:
    """Whether a fit leaves nothing to explain, by an assembly that may be."""
    return fit.gap <= bench.flat and (ordinary(fit) or not bench.free.deviations)


def _from_frequencies(bench: Bench, fit: Fit) -> list[Fit]:
    """A fit once more, its last effect as large as the frequencies of the ring-down want it; none if they do not.

    What sits at the root or at every sensor an assembly does as well by many deviations, of the sensors' masses or of
    the fields: from there nothing says that one number would do. Without an assembly thickness, density and Young's
    modulus do nearly the same, and a fit that began with a small effect creeps.
    """
    candidates = fit.problem.candidates
    if not len(bench.poles) or len(candidates[-1].slots) != 1 or not model_of(candidates[-1].effect).moves_poles:
        return []
    former = fit.u[bench.free.size : -1]
    (begin,) = starts(candidates, bench.free, bench.poles, 1, former)
    return [annealed(bench, short(bench, candidates, begin.u, COARSE), COARSE / 6)]


def _from_rest(bench: Bench, fit: Fit) -> list[Fit]:
    """A fit once more, its last effect begun where it does most for an assembly at rest.

    Many small numbers of an assembly that was bent do the work of one effect, and leave so little of it to see that
    neither its size nor its place would move.
    """
    *former, last = fit.problem.candidates
    rest = at_rest(bench.free, fit.u)[: len(fit.u) - len(last.slots)]
    screen = Screen(Problem(bench.thin, bench.free, tuple(former), COARSE), rest, bench.poles)
    found: list[Fit] = []
    for begin in screen.begins(last)[:BEGINS]:
        found.append(annealed(bench, short(bench, fit.problem.candidates, begin.u, COARSE), COARSE / 6))
        if is_sound(bench, found[-1]):
            break
    return found
