"""Fits of an effect in which contacts open and close, each sine weighed by how well the law follows it.

Beside a resonance such a law is right or wrong: squares in noise units would have all numbers follow the one block that
is furthest off. What is minimised is the score of `rough_starts`, by least squares whose weights follow from the fit
before (Holland and Welsch, Commun. Stat. A 6, 1977, 813, with Cauchy's weights, one for a sine on an accelerometer).
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.gap.conditioning.reduce import Reduced
from modallab.gap.model.fit import Fit, Problem, seen
from modallab.gap.model.minimise import minimise
from modallab.gap.search.few_blocks import even_blocks
from modallab.gap.search.fitting import Bench
from modallab.gap.search.rough_starts import COUNTS, EXACT, FREQUENCIES, relative, score, sizes

Array = NDArray[np.float64]

FORGIVEN = 0.1
"""Relative error that is forgiven of hits, which run through every state of a law."""
WORSE = 10.0
"""By how much the sines' score may rise for what the hits say of the high modes' damping."""


def followed(problem: Problem, u: Array, rounds: int) -> Array:
    """The numbers that follow the sines best, from u on."""
    best, least = u, score(problem, u)
    for _ in range(rounds):
        weighed = replace(problem, data=_weighed(problem.data, relative(problem, u)), floor=0.0)
        u = minimise(weighed, u, 2, 1e-2).u
        now = score(problem, u)
        if now < least:
            best = u
        if now > least - 1.0:
            break
        least = now
    return best


def followed_on_all(bench: Bench, fit: Fit) -> Fit:
    """A fit to few sines brought to its end on all, then with what the hits say of the high modes' damping."""
    exact = Problem(bench.data, bench.free, fit.problem.candidates)
    sines = replace(exact, data=replace(bench.data, impacts=()))
    u = followed(sines, fit.u, 3)
    held = (float(u[0]), float(u[1]), float(u[2]))
    after = minimise(replace(exact, floor=FORGIVEN, held=held), u, 2, 3e-2).u
    return seen(exact, after if score(sines, after) < score(sines, u) + WORSE else u)


def follows(bench: Bench, fit: Fit, base: Fit, share: float) -> bool:
    """Whether a fit leaves no more than a share of what one without it leaves, median over sines and channels."""
    few = even_blocks(bench.data, FREQUENCIES)
    left = [relative(replace(f.problem, data=few), f.u) for f in (fit, base)]
    return float(np.median(left[0])) <= share * float(np.median(left[1]))


def _weighed(data: Reduced, off: Array) -> Reduced:
    assert data.sines is not None
    rows, lines = data.sines.rows, data.sines.source.lines.shape[1]
    sigma = sizes(data) * np.hypot(off, EXACT) / np.sqrt(COUNTS / 2)
    own = np.where(np.isfinite(rows.sigma), np.repeat(sigma, lines, axis=1), np.inf)
    return replace(data, sines=replace(data.sines, rows=replace(rows, sigma=own, common=np.zeros(len(rows.common)))))
