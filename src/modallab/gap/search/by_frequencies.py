"""A round begun at the frequencies of the ring-down, with the assembly at rest.

Where many small numbers of an assembly do an effect's work, neither what is left nor its slopes say anything of the
effect. The frequencies do: each effect that moves them begins as large, and where, as they want it.
"""

from concurrent.futures import ThreadPoolExecutor
from itertools import repeat

from modallab.core.progress import counted
from modallab.gap.model.fit import Fit
from modallab.gap.model.prefit import starts
from modallab.gap.search.fitting import COARSE, Bench, annealed, completed, short
from modallab.gap.search.pool import pool
from modallab.gap.search.round import WORKERS, Level
from modallab.twin.candidate import Candidate
from modallab.twin.effects import model_of

BEGINS = 2
"""Places along the beam from which an effect with a place begins."""
FINISHED = 2
"""Explanations that are fitted to the end."""


def round_by_frequencies(bench: Bench, base: Fit) -> Level:
    """Every effect that moves the frequencies, begun where those want it; the best are fitted to the end."""
    listed = [c for c in pool(bench, base) if model_of(c.effect).moves_poles] if len(bench.poles) else []
    former = base.problem.candidates, base.u[bench.free.size :]

    def look(candidate: Candidate) -> Fit:
        candidates = (*former[0], candidate)
        begins = starts(candidates, bench.free, bench.poles, BEGINS if len(candidate.slots) > 1 else 1, former[1])
        looks = (annealed(bench, short(bench, candidates, b.u, COARSE), COARSE / 6) for b in begins)
        return min(looks, key=_cost)

    with ThreadPoolExecutor(WORKERS) as workers:
        looked = counted(workers.map(look, listed), len(listed), "explanations by the frequencies")
        looks = sorted(looked, key=_cost)
        best = sorted(workers.map(completed, repeat(bench), looks[:FINISHED]), key=_cost)
    return Level(base, tuple(best), tuple((f.problem.candidates, f.cost) for f in looks))


def _cost(fit: Fit) -> float:
    return fit.cost
