"""Which effect that depends on the size of the motion explains what no linear beam does, by the same likelihood.

Each such effect, a law, is stepped in time. Its rows are poles and modal constants of the hits, and the lines about a
few sines and about their overtones. A law is right or wrong for a record as a whole: a resonance that it bends jumps
there or does not. So each record, and each of its overtones, has its own scale of the discrepancy. Its cost grows with
the logarithm of what is left, which shows the way from afar; one channel alone never decides.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.progress import report_progress
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.posterior import Posterior, maximise_posterior
from modallab.gap.inference.screen import Screen
from modallab.gap.inference.select import SearchRound
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.inference.view import RowModel
from modallab.gap.model.candidates import stepped_candidates
from modallab.gap.model.fit import Fit, Problem, cost_of, fit_at
from modallab.gap.model.minimise import minimise
from modallab.gap.search.along_beam import best_along_beam
from modallab.gap.search.few_blocks import compared_sines
from modallab.gap.search.fitting import Bench, without_effect
from modallab.gap.search.force_place import locate_by_overtones
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effect_model import Overtones

SOFT = {"clamp_friction": "k_slip", "clearance": "k_within"}
"""Laws that leave the root soft even where their element does nothing, and the stiffness that stays."""
ROOT = "clamp_rotation"
"""The effect that such a root is without the element."""
FREQUENCIES = 12
"""Sines on which laws are compared, beside those with the most overtones."""
ROUNDS, STEPS, ON_RECORDS = 4, 4, 6
"""Evaluations of all slopes on a few sines, of those of the law alone in each, and of all slopes on all records."""


def law_round(bench: Bench, base: Fit, overtones: Overtones) -> SearchRound:
    """One round of the laws that make such overtones, beside the effects of a fit."""
    listed = [c for c in stepped_candidates(bench.data.rig, overtones) if bench.allowed(c.effect)]
    if not listed or bench.data.sines is None:
        return SearchRound(base, ())
    beside = _with_their_bases(base, listed)
    found = sorted((f for begin, laws in beside if laws for f in _on_few_sines(bench, begin, laws)), key=_evidence_of)
    fits = list[Fit]()
    for f in found:
        report_progress(0.7, f"{f.problem.candidates[-1].effect.replace('_', ' ')}, on all records")
        # One that is less probable by the price of an effect is no rival.
        if f.evidence < found[0].evidence + DEFAULT.effect_price:
            fits.append(fit_on_all_records(bench, f.problem.candidates, f.u))
    return SearchRound(base, tuple(sorted(fits, key=cost_of)))


def _with_their_bases(base: Fit, listed: Sequence[CandidateEffect]) -> Iterator[tuple[Fit, Sequence[CandidateEffect]]]:
    """The laws, and what each stands beside: one that leaves the root soft takes the place of a soft root."""
    names = [c.effect for c in base.problem.candidates]
    if ROOT not in names:
        yield base, listed
        return
    yield base, [c for c in listed if c.effect not in SOFT]
    problem, u = without_effect(base.problem, base.u, names.index(ROOT))
    yield fit_at(problem, u), [c for c in listed if c.effect in SOFT]


def fit_on_all_records(bench: Bench, candidates: tuple[CandidateEffect, ...], u: Real) -> Fit:
    """A law, and the effects beside it, fitted to all records from these numbers on."""
    found = minimise(Problem(bench.data, bench.free, candidates), u, ON_RECORDS, 1e-2)
    elsewhere = best_along_beam(found)
    return found if elsewhere is found else minimise(found.problem, elsewhere.u, ON_RECORDS, 1e-2)


def _on_few_sines(bench: Bench, base: Fit, listed: Sequence[CandidateEffect]) -> list[Posterior]:
    """The laws that are more probable than none, best first, each at its most probable numbers."""
    few = compared_sines(bench.data, bench.overtones, FREQUENCIES)
    view, coarse = (RowModel.of(bench.points, d, DEFAULT, "record") for d in (few, _with_long_steps(few)))
    problem = Problem(bench.data, bench.free, base.problem.candidates)
    without = maximise_posterior(view, problem, base.u, STEPS)
    at_rest = np.concatenate([np.zeros(bench.free.size), base.u[bench.free.size :]])
    located = [locate_by_overtones(bench, base, candidate) for candidate in listed]
    starts = (_likeliest(Screen(coarse, problem, u), located) for u in (without.u, at_rest))
    fitted = (_fitted(view, s.problem, s.u) for s in starts if s is not None)
    found = sorted((f for f in fitted if f.evidence + DEFAULT.effect_price < without.evidence), key=_evidence_of)
    best = {f.problem.candidates[-1].effect: f for f in reversed(found)}
    return sorted(best.values(), key=_evidence_of)


def _likeliest(screen: Screen, listed: Sequence[CandidateEffect]) -> Posterior | None:
    """The most probable of all laws after a few steps with the slopes of one screen; None without any."""
    found: list[Posterior] = []
    for i, candidate in enumerate(listed):
        report_progress(0.5 * i / len(listed), f"{candidate.effect.replace('_', ' ')}, stepped in time")
        starts = (screen.improved(start) for start in screen.starts(candidate, 1))
        found += [maximise_posterior(screen.view, s.problem, s.u, STEPS, screen.J) for s in starts]
    return min(found, key=_evidence_of, default=None)


def _fitted(view: RowModel, problem: Problem, u: Real) -> Posterior:
    """The law at its most probable numbers; slopes of the bench's many numbers, each a step in time, serve for long."""
    n, found = problem.free.size, maximise_posterior(view, problem, u, 0)
    for _ in range(ROUNDS):
        before, twin = found.cost, problem.twin(found.u)
        match = view.matched(twin)
        slopes = view.slopes(problem, found.u, match, view.predict(twin, match))
        found = maximise_posterior(view, problem, found.u, STEPS, slopes[:, :n])
        if before - found.cost < DEFAULT.effect_price:
            break
    return found


def _evidence_of(found: Posterior) -> float:
    return found.evidence


def _with_long_steps(data: Reduced) -> Reduced:
    """The same data, predicted with long steps in time: for a first look."""
    assert data.sines is not None
    return replace(data, sines=replace(data.sines, source=replace(data.sines.source, coarse=True)))
