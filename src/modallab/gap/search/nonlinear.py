"""Which effect that depends on the size of the motion explains what no linear beam does.

Such an effect has to be stepped in time. Each is followed on a few sines first, one at each frequency; the best of them
are fitted to all records.
"""

from collections.abc import Sequence
from dataclasses import replace

from modallab.core.progress import report_progress
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.select import Level
from modallab.gap.model.candidates import stepped_candidates
from modallab.gap.model.fit import Fit, Problem, cost_of
from modallab.gap.model.minimise import minimise
from modallab.gap.search.along_beam import best_along_beam
from modallab.gap.search.few_blocks import compared_sines
from modallab.gap.search.fitting import Bench
from modallab.gap.search.rough_fit import beam_of_hits, explains_sines, robust_fit_on_all
from modallab.gap.search.rough_starts import FREQUENCIES, robust_cost
from modallab.gap.search.stepped_starts import first_fit
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effect_model import Overtones
from modallab.twin.effects import search_of

CLOSE = 40.0
"""By how much more than the best a rival may score; what scores more is not fitted to all records."""
WRONG = 0.5
"""Share of what a linear beam leaves on few records from which an effect explains nothing."""
MOST_ON_ALL_RECORDS = 3
"""Explanations that are fitted to all records, where they score nearly alike."""


def stepped_round(bench: Bench, base: Fit, overtones: Overtones) -> Level:
    """One round of the effects that depend on the size of the motion and make such overtones, beside those of a fit."""
    listed = [c for c in stepped_candidates(bench.data.rig, overtones) if bench.allowed(c.effect)]
    if not listed or bench.data.sines is None:
        return Level(base, ())
    few = compared_sines(bench.data, bench.overtones, FREQUENCIES)
    scored = _best_forms(_scores(bench, base, few, listed))
    if not scored or not _explains(bench, *scored[0], base):
        return Level(base, ())
    least, best = scored[0]
    report_progress(0.7, f"{best.problem.candidates[-1].effect.replace('_', ' ')}, on all records")
    fits: list[Fit] = []
    for near in [fit for score, fit in scored if score < least + CLOSE][:MOST_ON_ALL_RECORDS]:
        # Beside one that leaves nothing but noise there is no rival.
        if not any(fit.gap <= bench.flat for fit in fits):
            fits.append(fit_on_all_records(bench, near))
    return Level(base, tuple(sorted(fits, key=cost_of)))


def _scores(bench: Bench, base: Fit, few: Reduced, listed: Sequence[CandidateEffect]) -> list[tuple[float, Fit]]:
    """The robust cost and the fit of each effect on a few sines, best first."""
    found: list[tuple[float, Fit]] = []
    for i, candidate in enumerate(listed):
        report_progress(0.7 * i / len(listed), f"{candidate.effect.replace('_', ' ')}, stepped in time")
        fit = first_fit(bench, base, few, candidate)
        found += [] if fit is None else [(robust_cost(fit.problem, fit.u), fit)]
    return sorted(found, key=lambda one: one[0])


def _explains(bench: Bench, score: float, fit: Fit, base: Fit) -> bool:
    """Whether an effect leaves much less of a few sines than a linear beam does.

    That may follow each sine, stretched far beyond its tolerances: a law that all records follow needs no more than to
    stand well within them.
    """
    stretched = robust_cost(replace(base.problem, data=fit.problem.data, floor=0.0), base.u)
    smooth = search_of(fit.problem.candidates[-1].effect).law.smooth
    return (smooth and score <= WRONG * stretched) or explains_sines(bench, fit, base, WRONG)


def _best_forms(scored: list[tuple[float, Fit]]) -> list[tuple[float, Fit]]:
    """Of each effect the first form of its law, in their order."""
    first: dict[str, tuple[float, Fit]] = {}
    for score, fit in scored:
        first.setdefault(fit.problem.candidates[-1].effect, (score, fit))
    return list(first.values())


def fit_on_all_records(bench: Bench, fit: Fit) -> Fit:
    """A fit to few records brought to its end on all data.

    A hit runs through every state of a law at once: it moves the law's own numbers only where that has one state, a
    smooth power. Else it moves the beam's alone.
    """
    found = robust_fit_on_all(bench, fit)
    if not search_of(fit.problem.candidates[-1].effect).law.smooth:
        return min(found, beam_of_hits(bench, found), key=cost_of)
    exact = Problem(bench.data, bench.free, fit.problem.candidates)
    found = best_along_beam(minimise(exact, found.u, 3, 1e-2))
    return minimise(exact, found.u, 6, 1e-3)
