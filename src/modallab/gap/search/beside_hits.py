"""What hangs on the beam in the sine test alone, found beside the beam that the hits show.

Where an ordinary bench explains the hits, the beam is known, and what the sines add sits at the shaker. On both tests
together the assembly bends to it instead, and a search from there, or from the assembly at rest, is long.
"""

from dataclasses import replace

from modallab.core.effects import kind_of
from modallab.core.progress import report
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.search.ending import is_sound
from modallab.gap.search.fitting import COARSE, Bench, annealed, baseline, completed, on_all, short
from modallab.gap.search.pool import pool
from modallab.gap.search.screen import Screen
from modallab.twin.candidate import Candidate

BEGINS = 2
"""Sizes from which a candidate is fitted."""


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
    begins = screen.begins(candidate)[:BEGINS]
    return [annealed(bench, short(bench, (candidate,), b.u, COARSE), COARSE / 6) for b in begins]


def _cost(fit: Fit) -> float:
    return fit.cost
