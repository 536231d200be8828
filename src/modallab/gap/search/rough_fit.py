"""Fits of an effect in which contacts open and close, each sine weighed by how well the law follows it.

Beside a resonance such a law is right or wrong: squares in noise units would have all numbers follow the one block that
is furthest off. What is minimised is the score of `rough_starts`, by least squares whose weights follow from the fit
before (Holland and Welsch, Commun. Stat. A 6, 1977, 813, with Cauchy's weights, one for a sine on an accelerometer).
"""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit, Problem, evaluated
from modallab.gap.model.minimise import minimise
from modallab.gap.search.few_blocks import compared_sines
from modallab.gap.search.fitting import Bench
from modallab.gap.search.overtone_lines import LINES, with_overtones
from modallab.gap.search.rough_starts import (
    COUNTS,
    FREQUENCIES,
    is_overtone,
    relative_residual,
    robust_cost,
    sine_sizes,
    smallest_error,
)

FORGIVEN = 0.1
"""Relative error that is forgiven of hits, which run through every state of a law."""
NEARLY = 0.015
"""The same where the law is known: the numbers of an ordinary bench are felt below 0.02."""
FOLLOWED = 0.02
"""Share of a sine's size that may be left of it where a linear beam follows it."""
WORSE = 10.0
"""By how much the sines' score may rise for what the hits say of the high modes' damping."""


def robust_fit(problem: Problem, u: Real, rounds: int) -> Real:
    """The numbers that follow the sines best, from u on."""
    best, least = u, robust_cost(problem, u)
    for _ in range(rounds):
        weighed = replace(problem, data=_with_weights(problem.data, relative_residual(problem, u)), floor=0.0)
        u = minimise(weighed, u, 2, 1e-2).u
        now = robust_cost(problem, u)
        if now < least:
            best = u
        if now > least - 1.0:
            break
        least = now
    return best


def robust_fit_on_all(bench: Bench, fit: Fit) -> Fit:
    """A fit to few sines brought to its end on all, then with what the hits say of the high modes' damping."""
    whole = Problem(bench.data, bench.free, fit.problem.candidates)
    sines = replace(whole, data=with_overtones(replace(bench.data, impacts=()), bench.overtones))
    u = robust_fit(sines, fit.u, 2)
    return evaluated(whole, _with_hits(sines, bench.data, u))


def _with_hits(sines: Problem, data: Reduced, u: Real) -> Real:
    """The beam's numbers from hits as well, if the sines stay followed; overtones and sines hold the law."""
    after = minimise(_hits_and_sines(sines, data, u, FORGIVEN), u, 2, 3e-2).u
    return after if robust_cost(sines, after) < robust_cost(sines, u) + WORSE else u


def beam_of_hits(bench: Bench, fit: Fit) -> Fit:
    """The same law on the beam that hits and sines show together.

    A law that is a little off elsewhere leads the hits astray, so that they must not move its own numbers.
    """
    whole = Problem(bench.data, bench.free, fit.problem.candidates)
    own = fit.u[bench.free.size + sum(len(c.slots) for c in whole.candidates[:-1]) :]
    *before, law = whole.candidates
    fixed = [replace(s, low=s.value(v), high=s.value(v)) for s, v in zip(law.slots, own, strict=True)]
    audible = with_overtones(replace(bench.data, impacts=()), bench.overtones)
    held = replace(whole, data=audible, candidates=(*before, replace(law, slots=tuple(fixed))))
    return evaluated(whole, minimise(_hits_and_sines(held, bench.data, fit.u, NEARLY), fit.u, 2, 3e-2).u)


def _hits_and_sines(sines: Problem, data: Reduced, u: Real, floor: float) -> Problem:
    """Hits of which some is forgiven beside sines that are weighed by how they are followed."""
    both = replace(_with_weights(sines.data, relative_residual(sines, u)), impacts=data.impacts)
    return replace(sines, data=both, floor=floor, held=(float(u[0]), float(u[1]), float(u[2])))


def explains_sines(bench: Bench, fit: Fit, base: Fit, share: float) -> bool:
    """Whether a fit leaves no more than a share of what one without it leaves, median over sines and channels.

    Where the sines themselves are followed without it, their overtones say so.
    """
    few = compared_sines(bench.data, bench.overtones, FREQUENCIES)
    left, before = (relative_residual(replace(f.problem, data=few), f.u) for f in (fit, base))
    above = is_overtone(few)
    if np.any(above) and float(np.median(before[:, ~above])) < FOLLOWED:
        audible = before[:, above] > 0
        return float(np.median(left[:, above][audible])) <= share and float(np.median(left[:, ~above])) < FOLLOWED
    return float(np.median(left[:, ~above])) <= share * float(np.median(before[:, ~above]))


def _with_weights(data: Reduced, off: Real) -> Reduced:
    assert data.sines is not None
    rows = data.sines.rows
    sigma = sine_sizes(data) * np.hypot(off, smallest_error(data)) / np.sqrt(COUNTS / 2)
    own = np.where(np.isfinite(rows.sigma), np.repeat(sigma, LINES, axis=1), np.inf)
    return replace(data, sines=replace(data.sines, rows=replace(rows, sigma=own, common=np.zeros(len(rows.common)))))
