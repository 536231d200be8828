"""What hangs on the beam in the sine test alone, found beside the beam that the hits show.

Where an ordinary bench explains the hits, the beam is known, and what the sines add sits at the shaker. On both tests
together the assembly bends to it instead, and a search from there, or from the assembly at rest, is long.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.effects import kind_of
from modallab.core.progress import report
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.search.ending import is_sound
from modallab.gap.search.fitting import COARSE, Bench, annealed, baseline, completed, on_all, short
from modallab.gap.search.pool import pool
from modallab.gap.search.screen import OUTLIER, Screen
from modallab.twin.candidate import Candidate

BEGINS = 2
"""Sizes from which a candidate is fitted."""
SIZES = 33
"""Sizes that are looked at between a first one and its neighbours."""

Array = NDArray[np.float64]


def only_hits(bench: Bench) -> Bench:
    """The same without the sine test."""
    return replace(bench, data=replace(bench.data, sines=None), thin=replace(bench.thin, sines=None))


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
    fits = sorted((f for c in listed for f in _fitted(bench, known, c)), key=_cost)
    best = completed(bench, fits[0]) if fits else None
    return best if best is not None and is_sound(bench, best) else None


def _fitted(bench: Bench, known: Fit, candidate: Candidate) -> list[Fit]:
    screen = Screen(Problem(bench.thin, bench.free, (), COARSE), known.u, bench.poles)
    begins = [b.u for b in screen.begins(candidate)[:BEGINS]]
    if len(candidate.slots) == 1:
        begins.append(_sized(bench, known, candidate, float(begins[0][-1])))
    return [annealed(bench, short(bench, (candidate,), u, COARSE), COARSE / 6) for u in begins]


def _sized(bench: Bench, known: Fit, candidate: Candidate, near: float) -> Array:
    """The known beam with the effect in the size about `near`, a coordinate, that leaves least.

    Where the beam is known the right size stands out, too narrow for the first sizes and for slopes from them: to
    either side of it resonances lie apart.
    """
    (slot,) = candidate.slots
    first = np.sort([slot.coordinate(v) for v in slot.starts])
    step = float(np.max(np.diff(first))) if len(first) > 1 else 1.0
    problem = Problem(bench.thin, bench.free, (candidate,), COARSE / 6)
    tried = [np.append(known.u, v) for v in near + step * np.linspace(-1.0, 1.0, SIZES)]
    costs = [float(np.sum(np.minimum(problem.residual(u) ** 2, OUTLIER))) for u in tried]
    return tried[int(np.argmin(costs))]


def _cost(fit: Fit) -> float:
    return fit.cost
