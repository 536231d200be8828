"""Where the fit of an effect that is stepped in time begins: the likeliest of its starts, on few records."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.candidates import of_bench
from modallab.gap.model.fit import Fit, Problem, seen
from modallab.gap.model.minimise import WORKERS, minimise
from modallab.gap.model.prefit import start
from modallab.gap.search.few_blocks import looked_at
from modallab.gap.search.fitting import Bench
from modallab.gap.search.force_place import placed_by_overtones
from modallab.gap.search.rough_fit import followed
from modallab.gap.search.rough_starts import FREQUENCIES, apart, likeliest, score
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effects import search_of

LOOKED = 0.1
"""Relative error that is forgiven in a first look."""
PLACES = 3
"""Places along the beam at which an effect that has one is begun from."""
OUTLIER = 100.0
"""Square at which a residual stops counting where starts are compared."""


def begun(bench: Bench, base: Fit, some: tuple[Reduced, Reduced], candidate: CandidateEffect) -> list[Fit]:
    """The effect after a few steps on few records from the best of its starts on even fewer, best first.

    None where the overtones show that what makes them acts in no such way at any place.
    """
    located = placed_by_overtones(bench, base, candidate)
    if located is None:
        return []
    problem = Problem(some[0], bench.free, (*base.problem.candidates, located), LOOKED)
    law, names = search_of(candidate.effect).law, [s.name for s in located.slots]
    listed = [dict(zip(names, own, strict=True)) for own in product(*(slot.starts for slot in located.slots))]
    begins = [
        (own.get("x", float(beam)), u)
        for own in listed
        if law.acting(own)
        for beam, u in enumerate(_begins(bench, base, located, tuple(own.values())))
    ]
    if law.by_sine:
        even = replace(problem, data=looked_at(bench.data, bench.overtones, FREQUENCIES), floor=0.0)
        u = _by_sine(even, [u for _, u in begins], law.rough)
        return [seen(problem, u)]
    chosen = _one_a_place(replace(problem, data=some[1]), begins)

    def first(u: Real) -> Fit:
        return minimise(replace(problem, held=beam_at(u)), u, 2, 3e-2)

    with ThreadPoolExecutor(WORKERS) as workers:
        return sorted(workers.map(first, chosen), key=lambda f: f.cost)


def _by_sine(even: Problem, begins: list[Real], rough: bool) -> Real:
    """Where the sines are followed best; slopes lead there from the likeliest starts, or after these were polished."""
    assert even.data.sines is not None
    coarse = replace(even.data.sines.source, coarse=True)
    starts = replace(even, data=replace(even.data, sines=replace(even.data.sines, source=coarse)))
    if rough:
        return followed(even, likeliest(starts, begins), 2)
    return min((followed(even, u, 2) for u in apart(starts, begins)), key=lambda u: score(even, u))


def _one_a_place(problem: Problem, begins: list[tuple[float, Real]]) -> list[Real]:
    """The likeliest start at each of the likeliest places: a place is seldom left again.

    Of a law that is everywhere the likeliest with each beam: one that stops all resonances leaves little of any.
    """

    def cost(u: Real) -> float:
        return float(np.sum(np.minimum(problem.residual(u) ** 2, OUTLIER)) + problem.priors(u)[0])

    with ThreadPoolExecutor(WORKERS) as workers:
        costs = list(workers.map(cost, (u for _, u in begins)))
    best: dict[float, Real] = {}
    for i in np.argsort(costs):
        best.setdefault(begins[i][0], begins[i][1])
    return list(best.values())[:PLACES]


def beam_at(u: Real) -> tuple[float, float, float]:
    """Young's modulus, thickness and density of these numbers, in deviations, to hold a beam there."""
    return float(u[0]), float(u[1]), float(u[2])


def _begins(bench: Bench, base: Fit, candidate: CandidateEffect, values: tuple[float, ...]) -> Iterator[Real]:
    """Where a fit may begin: the beam as believed, and those that the poles of small and of large motion show."""
    own = np.array([s.coordinate(v) for s, v in zip(candidate.slots, values, strict=True)])
    beside = base.u[bench.free.size :]
    yield np.concatenate([np.zeros(bench.free.size), beside, own])
    if not len(bench.poles):
        return
    for alike, like in _linear(bench, candidate, own):
        try:
            poles = start((*base.problem.candidates, alike), np.concatenate([beside, like]), bench.free, bench.poles)
        except np.linalg.LinAlgError:
            # Two losses of stiffness at one place may leave none: no beam to begin from.
            continue
        yield np.concatenate([poles.u[: bench.free.size], beside, own])


def _linear(bench: Bench, candidate: CandidateEffect, own: Real) -> Iterator[tuple[CandidateEffect, Real]]:
    """Linear effects with nearly the same poles."""
    names = [s.name for s in candidate.slots]
    if "EI_loss_open" not in names:
        yield candidate, own
    for soft, stiff in (("k_slip", "k_stick"), ("k_within", "k_contact")):
        if soft in names:
            held = own.copy()
            held[names.index(soft)] = own[names.index(stiff)]
            yield candidate, held
    if "EI_loss_open" in names:
        share = candidate.at(own).parameters["EI_loss_open"]
        # Half of the time it bends as a crack that stays open.
        half = share / (2 - share)
        for like in of_bench(bench.data.rig):
            if like.effect == "stiffness_loss":
                yield like, np.array([like.slots[0].coordinate(half), own[names.index("x")]])
