"""What hangs on the beam in the sine test alone, found beside the beam that the hits show.

Where an ordinary bench explains the hits, the beam is known, and what the sines add sits at the shaker. On both tests
together the assembly bends to it instead, and a search from there, or from the assembly at rest, is long.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.effects import kind_of
from modallab.core.progress import report
from modallab.gap.model.fit import Fit, Problem, cost_of
from modallab.gap.search.ending import is_sound
from modallab.gap.search.fitting import COARSE, Bench, annealed, baseline, completed, on_all, short
from modallab.gap.search.lows import lows
from modallab.gap.search.pool import pool
from modallab.gap.search.screen import Screen, capped
from modallab.twin.candidate import Candidate

BEGINS = 2
"""Sizes from which a candidate is fitted."""
FINER = 10
"""Sizes that are looked at from one first size to the next."""

Array = NDArray[np.float64]


def only_hits(bench: Bench) -> Bench:
    """The same without the sine test."""
    return replace(bench, data=replace(bench.data, sines=None), thin=replace(bench.thin, sines=None))


def only_sines(bench: Bench) -> Bench:
    """The same without the hits; their ring-down is known as before."""
    return replace(bench, data=replace(bench.data, impacts=()), thin=replace(bench.thin, impacts=()))


def beside_the_hits(bench: Bench) -> Fit | None:
    """The twin with the effect of the sine test that explains all; None if there is none, or the hits need another."""
    if bench.data.sines is None or not bench.data.impacts or not bench.free.deviations:
        return None
    report(0.0, "the hits alone")
    alone = only_hits(bench)
    hits = baseline(alone)
    if not is_sound(alone, hits):
        return None
    known = on_all(bench, hits)
    listed = [c for c in pool(bench, known) if kind_of(c.effect).tests == ("sine",)]
    fits = sorted((f for c in listed for f in _fitted(bench, known, c)), key=cost_of)
    best = completed(bench, fits[0]) if fits else None
    return best if best is not None and is_sound(bench, best) else None


def _fitted(bench: Bench, known: Fit, candidate: Candidate) -> list[Fit]:
    screen = Screen(Problem(bench.thin, bench.free, (), COARSE), known.u, bench.poles)
    begins = [b.u for b in screen.begins(candidate)[:BEGINS]]
    if len(candidate.slots) == 1:
        begins += _sized(bench, known, candidate)
    return [annealed(bench, short(bench, (candidate,), u, COARSE), COARSE / 6) for u in begins]


def _sized(bench: Bench, known: Fit, candidate: Candidate) -> list[Array]:
    """The known beam with the effect in the sizes that leave least of all, a few.

    Where the beam is known the right size stands out, too narrow for the first sizes and for slopes from them: to
    either side of it resonances lie apart.
    """
    first = np.sort([candidate.slots[0].coordinate(v) for v in candidate.slots[0].starts])
    sizes = np.interp(np.arange(0, len(first) - 1, 1 / FINER), np.arange(len(first)), first)
    problem = Problem(bench.thin, bench.free, (candidate,), COARSE / 6)
    tried = [np.append(known.u, v) for v in sizes]
    costs = [capped(problem, u) for u in tried]
    return [tried[i] for i in sorted(lows(costs), key=lambda i: costs[i])[:BEGINS]]
