"""An effect at other places along the beam: few sensors leave a low of the misfit between any two nodes.

A fit stays in the low where it began. Each place is tried with everything else fitted, and the best are let go.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.gap.model.fit import Fit
from modallab.gap.model.minimise import minimise

PLACES: tuple[float, ...] = tuple(np.linspace(0.06, 0.99, 16).tolist())
"""Places over L that are tried."""
LET_GO = 2
"""Of these, how many are fitted with their place free."""
STEPS, LONG = 2, 8
"""Evaluations of the slopes at each place, and once it is free."""


def at_best_place(fit: Fit) -> Fit:
    """The fit, or a better one of the same effect at another place; the fit where no single effect has a place."""
    candidates = fit.problem.candidates
    names = [s.name for c in candidates for s in c.slots]
    if len(candidates) != 1 or "x" not in names:
        return fit
    at = fit.problem.free.size + names.index("x")
    x, others = candidates[0].slots[names.index("x")], np.delete(fit.u, at)
    tried = [
        minimise(replace(fit.problem, candidates=(candidates[0].with_fixed_place(p),)), others, STEPS, 1e-2)
        for p in PLACES
    ]
    best = sorted(local_minima([f.cost for f in tried]), key=lambda k: tried[k].cost)[:LET_GO]
    begins = [np.insert(tried[k].u, at, x.coordinate(PLACES[k])) for k in best]
    return min([fit, *(minimise(fit.problem, u, LONG, 1e-4) for u in begins)], key=lambda f: f.cost)


def local_minima(values: Sequence[float]) -> list[int]:
    """Places of the values that are no higher than those beside them, in their order."""
    wide = np.array([np.inf, *values, np.inf])
    return np.flatnonzero((wide[1:-1] <= wide[:-2]) & (wide[1:-1] <= wide[2:])).tolist()
