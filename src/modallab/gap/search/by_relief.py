"""A round begun from what would let a bent assembly go back to rest.

Where many small numbers of an assembly do an effect's work, they fit the data nearly as well as the effect does, and
little is left to see. But they strain their tolerances: what would relieve them, beside data that stay as they are, is
the effect.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

from modallab.core.progress import counted
from modallab.gap.model.fit import Fit, Problem, cost_of
from modallab.gap.search.fitting import Bench, annealed, completed, settled, short
from modallab.gap.search.pool import pool
from modallab.gap.search.round import WORKERS, Level
from modallab.gap.search.screen import Begin, Screen

FORGIVEN = 0.01
"""Relative model error that is forgiven while effects are screened: what first order leaves of a size that shows."""
STEPS = 6
"""Slopes that are evaluated at first."""
LIKELY = 6
"""Effects that are fitted."""
FINISHED = 2
"""Explanations that are fitted to the end."""


def round_by_relief(bench: Bench, base: Fit) -> Level:
    """Every effect as large as relieves the assembly most; the likeliest are fitted from there, the best to the end."""
    problem = Problem(bench.thin, bench.free, base.problem.candidates, FORGIVEN)
    screen = Screen(problem, base.u, bench.poles, relieved=True)
    listed = pool(bench, base)
    with ThreadPoolExecutor(WORKERS) as workers:
        screened = counted(workers.map(screen.begins, listed), len(listed), "explanations that would relieve the bench")
        begins = sorted((b[0] for b in screened), key=_left)[:LIKELY]
        looks = sorted(workers.map(partial(_looked, bench), begins), key=cost_of)
        if not looks:
            return Level(base, ())
        first, *others = sorted(workers.map(partial(completed, bench), looks[:FINISHED]), key=cost_of)
    return Level(base, (settled(first), *others))


def _looked(bench: Bench, begin: Begin) -> Fit:
    # Little is left to see where it begins: whatever is forgiven would excuse it all.
    return annealed(bench, short(bench, begin.problem.candidates, begin.u, 0.0, STEPS), 0.0)


def _left(begin: Begin) -> float:
    return begin.cost
