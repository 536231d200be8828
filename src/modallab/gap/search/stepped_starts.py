"""Where the fit of an effect that is stepped in time begins: the likeliest of its starts, on few records."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.candidates import beam_candidates
from modallab.gap.model.fit import Fit, Problem, evaluated
from modallab.gap.model.prefit import start
from modallab.gap.search.fitting import Bench
from modallab.gap.search.force_place import placed_by_overtones
from modallab.gap.search.rough_fit import robust_fit
from modallab.gap.search.rough_starts import best_start
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effects import search_of


def first_fit(bench: Bench, base: Fit, few: Reduced, candidate: CandidateEffect) -> Fit | None:
    """The effect where it follows a few sines best, from the likeliest of its starts on.

    None where the overtones show that what makes them acts in no such way at any place.
    """
    located = placed_by_overtones(bench, base, candidate)
    if located is None:
        return None
    problem = Problem(few, bench.free, (*base.problem.candidates, located))
    law, names = search_of(candidate.effect).law, [s.name for s in located.slots]
    listed = [dict(zip(names, own, strict=True)) for own in product(*(slot.starts for slot in located.slots))]
    acting = [tuple(own.values()) for own in listed if law.acting(own)]
    begins = [u for values in acting for u in _first_coordinates(bench, base, located, values)]
    assert few.sines is not None
    coarse = replace(few.sines, source=replace(few.sines.source, coarse=True))
    begun = best_start(replace(problem, data=replace(few, sines=coarse)), begins)
    return evaluated(problem, robust_fit(problem, begun, 2))


def _first_coordinates(
    bench: Bench, base: Fit, candidate: CandidateEffect, values: tuple[float, ...]
) -> Iterator[Real]:
    """Where a fit may begin: the beam as believed, and those that the poles of small and of large motion show."""
    own = np.array([s.coordinate(v) for s, v in zip(candidate.slots, values, strict=True)])
    beside = base.u[bench.free.size :]
    yield np.concatenate([np.zeros(bench.free.size), beside, own])
    if not len(bench.poles):
        return
    for alike, like in _linear_likeness(bench, candidate, own):
        try:
            poles = start((*base.problem.candidates, alike), np.concatenate([beside, like]), bench.free, bench.poles)
        except np.linalg.LinAlgError:
            # Two losses of stiffness at one place may leave none: no beam to begin from.
            continue
        yield np.concatenate([poles.u[: bench.free.size], beside, own])


def _linear_likeness(bench: Bench, candidate: CandidateEffect, own: Real) -> Iterator[tuple[CandidateEffect, Real]]:
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
        for like in beam_candidates(bench.data.rig):
            if like.effect == "stiffness_loss":
                yield like, np.array([like.slots[0].coordinate(half), own[names.index("x")]])
