"""A round begun at the frequencies of the ring-down, with the assembly at rest.

Where many small numbers of an assembly do an effect's work, neither what is left nor its slopes say anything of the
effect. The frequencies do: each effect that moves them begins as large, and where, as they want it.
"""

from concurrent.futures import ThreadPoolExecutor
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from modallab.core.progress import counted
from modallab.gap.model.fit import Fit, cost_of
from modallab.gap.model.prefit import start, starts
from modallab.gap.search.ending import is_sound
from modallab.gap.search.fitting import COARSE, Bench, completed, on_all, short
from modallab.gap.search.halving import annealed_together
from modallab.gap.search.pool import pool
from modallab.gap.search.round import WORKERS, Level, best_of_each
from modallab.twin.candidate import Candidate
from modallab.twin.effects import model_of

Array = NDArray[np.float64]

BEGINS = 2
"""Places along the beam from which an effect with a place begins."""
SMALLER = 2
"""Smaller sizes from which an effect of one number begins as well."""
FOLLOWED = 8
"""Fits that are followed where nothing is forgiven any more."""
FINISHED = 2
"""Explanations that are fitted to the end."""


def round_by_frequencies(bench: Bench, base: Fit) -> Level:
    """Every effect that moves the frequencies, begun where those want it; the best are fitted to the end."""
    listed = [c for c in pool(bench, base) if model_of(c.effect).moves_poles] if len(bench.poles) else []
    former = base.problem.candidates, base.u[bench.free.size :]

    def looks(candidate: Candidate) -> list[Fit]:
        candidates = (*former[0], candidate)
        begins = starts(candidates, bench.free, bench.poles, BEGINS if len(candidate.slots) > 1 else 1, former[1])
        less = smaller(candidate, begins[0].u[bench.free.size + len(former[1]) :])
        begins = [*begins, *(start(candidates, np.append(former[1], u), bench.free, bench.poles) for u in less)]
        return [short(bench, candidates, b.u, COARSE) for b in begins]

    with ThreadPoolExecutor(WORKERS) as workers:
        looked = counted(workers.map(looks, listed), len(listed), "explanations by the frequencies")
        fits = [fit for own in looked for fit in own]
        likely = best_of_each(annealed_together(bench, fits, COARSE / 6, workers, len(fits), FOLLOWED))
        first = [completed(bench, f) for f in likely[:1]]
        # What led explains it by an ordinary bench: others need no last digits.
        last = on_all if any(is_sound(bench, f) for f in first) else completed
        best = sorted([*first, *workers.map(last, repeat(bench), likely[1:FINISHED])], key=cost_of)
    return Level(base, tuple(best))


def smaller(candidate: Candidate, own: Array) -> list[float]:
    """The coordinates of the next smaller first values of an effect of one number, the larger first.

    What sits at every sensor moves all frequencies as the beam's own numbers do, which hardly tell its size: from too
    large a size the assembly bends and the fit creeps, from a smaller one it grows.
    """
    if len(candidate.slots) != 1:
        return []
    (slot,) = candidate.slots
    value = slot.value(float(own[0]))
    size = -1.0 if slot.power < 0 else 1.0
    same_side = [v for v in slot.starts if (v - slot.none) * (value - slot.none) > 0]
    less = [v for v in same_side if size * abs(v - slot.none) < size * abs(value - slot.none)]
    nearest = sorted(less, key=lambda v: -size * abs(v - slot.none))
    return [slot.coordinate(v) for v in nearest[:SMALLER]]
