"""Which effect that depends on the size of the motion explains what no linear beam does.

Such an effect has to be stepped in time. A first look is taken at the sine blocks that a linear beam explains worst,
both levels of each frequency, with every start on its grid; the best are fitted there, and the best of those on all
data.
"""

from collections.abc import Callable
from dataclasses import replace

from modallab.core.progress import report_progress
from modallab.gap.inference.select import Level
from modallab.gap.model.candidates import of_motion
from modallab.gap.model.fit import Fit, Problem, cost_of, seen
from modallab.gap.model.minimise import minimise
from modallab.gap.search.along_beam import along_the_beam
from modallab.gap.search.few_blocks import looked_at, worst_blocks
from modallab.gap.search.fitting import NEAR, Bench
from modallab.gap.search.rough_fit import followed_on_all, follows
from modallab.gap.search.rough_starts import FREQUENCIES, score
from modallab.gap.search.stepped_starts import LOOKED, beam_at, begun
from modallab.twin.effect_model import Overtones
from modallab.twin.effects import search_of

BLOCKS = 6
"""Sine blocks of a first look that a linear beam explains worst."""
FEWEST = 4
"""The same where starts are compared."""
RIVAL = 150.0
"""By how much more than the best a rival may score; what scores more is not fitted on."""
CLOSE = 40.0
"""The same of what is fitted to all records."""
WRONG = 0.5
"""Share of what a linear beam leaves on few records from which an effect explains nothing."""
LONGER = 2
"""Effects of a group that are fitted on few records to the end."""
ENDED = 3
"""Effects that are fitted on all records, where they score nearly alike."""


def nonlinear_level(bench: Bench, base: Fit, overtones: Overtones) -> Level:
    """One round of the effects that depend on the size of the motion and make such overtones, beside those of a fit."""
    listed = [c for c in of_motion(bench.data.rig, overtones) if bench.allowed(c.effect)]
    if not listed or bench.data.sines is None:
        return Level(base, ())
    few, fewest = (worst_blocks(bench.data, base, count) for count in (BLOCKS, FEWEST))
    even = looked_at(bench.data, bench.overtones, FREQUENCIES)

    def score_of(fit: Fit) -> float:
        return score(replace(fit.problem, data=even, floor=0.0), fit.u)

    first: list[list[Fit]] = []
    for i, candidate in enumerate(listed):
        report_progress(0.5 * i / len(listed), f"{candidate.effect.replace('_', ' ')}, stepped in time")
        first.append(begun(bench, base, (few, fewest), candidate))
    best = [fits[0] for fits in first if fits]
    # Those that were followed sine by sine have come further than those that were only begun.
    groups = [[fit for fit in best if _by_sine(fit) is alike] for alike in (True, False)]
    hopeful = [fit for group in groups for fit in _near_the_best(group, score_of, RIVAL)[:LONGER]]
    report_progress(0.5, "the likeliest of them")
    looks = _best_forms(sorted(map(_fitted, hopeful), key=score_of), _by_sine)
    if not looks or not _explains(bench, looks[0], base, score_of):
        return Level(base, ())
    report_progress(0.7, f"{looks[0].problem.candidates[-1].effect.replace('_', ' ')}, on all records")
    fits = [on_all_records(bench, f) for f in _near_the_best(looks, score_of, CLOSE)[:ENDED]]
    return Level(base, tuple(_best_forms(sorted(fits, key=cost_of))))


def _by_sine(fit: Fit) -> bool:
    return search_of(fit.problem.candidates[-1].effect).law.by_sine


def _near_the_best(fits: list[Fit], score_of: Callable[[Fit], float], within: float) -> list[Fit]:
    """Those that score no more than so much above the best, best first."""
    scored = sorted(((score_of(fit), fit) for fit in fits), key=lambda pair: pair[0])
    return [fit for own, fit in scored if own < scored[0][0] + within]


def _explains(bench: Bench, fit: Fit, base: Fit, score_of: Callable[[Fit], float]) -> bool:
    search = search_of(fit.problem.candidates[-1].effect)
    if search.law.by_sine:
        # A linear beam may follow each sine, stretched far beyond its tolerances: a law that is exact needs no more
        # than to stand well within them.
        stretched = not search.inexact and score_of(fit) <= WRONG * score_of(base)
        return stretched or follows(bench, fit, base, WRONG)
    linear = seen(replace(fit.problem, candidates=base.problem.candidates, held=beam_at(base.u)), base.u)
    return fit.cost <= WRONG * linear.cost


def _best_forms(fits: list[Fit], known: Callable[[Fit], bool] = lambda fit: True) -> list[Fit]:
    """Of each effect the first form of its law, where that is `known` to be the better one; in their order.

    A few sines, each as a share of its own size, do not tell the forms of a smooth law apart: all records do.
    """
    seen_before: set[str] = set()
    best: list[Fit] = []
    for fit in fits:
        effect = fit.problem.candidates[-1].effect
        if not known(fit) or effect not in seen_before:
            best.append(fit)
        seen_before.add(effect)
    return best


def _fitted(fit: Fit) -> Fit:
    """The same with ever less forgiven."""
    if _by_sine(fit):
        return seen(replace(fit.problem, floor=LOOKED / 20, held=beam_at(fit.u)), fit.u)
    for floor, steps in ((LOOKED / 3, 2), (LOOKED / 20, 3)):
        # The beam that the poles show stays, as firmly as more is forgiven.
        fit = minimise(replace(fit.problem, floor=floor, held=beam_at(fit.u)), fit.u, steps, 3e-2)
    return fit


def on_all_records(bench: Bench, fit: Fit) -> Fit:
    """A fit to few records brought to its end on all data; of its stages the one that leaves least.

    The law may not be exact.
    """
    exact = Problem(bench.data, bench.free, fit.problem.candidates)
    if _by_sine(fit):
        found = followed_on_all(bench, fit)
        law = search_of(fit.problem.candidates[-1].effect)
        if law.inexact:
            return found
        found = along_the_beam(minimise(exact, found.u, 3, 1e-2))
        return minimise(exact, found.u, 6, 1e-3, whole=True)
    first = seen(exact, fit.u)
    # A hit runs through every state of a law at once: what is a little wrong there must not lead the sines astray.
    sines = replace(exact, data=replace(bench.data, impacts=()))
    for floor in (LOOKED / 5, LOOKED / 50):
        fit = minimise(replace(sines, floor=floor, held=beam_at(fit.u)), fit.u, 2, 3e-2)
    best = min(first, seen(exact, fit.u), key=cost_of)
    fit = minimise(replace(exact, floor=LOOKED / 5, held=beam_at(fit.u)), fit.u, 2, 3e-2)
    best = min(best, seen(exact, fit.u), key=cost_of)
    best = min(best, minimise(exact, best.u, 2, 1e-2), key=cost_of)
    # Where the law is exact, what is left to go lies along a valley: a place and a stiffness do nearly the same.
    return minimise(exact, best.u, 6, 1e-3) if best.gap < NEAR * bench.flat else best
