"""Whether a linear effect stands beside one that is stepped in time.

What the element adds to the records hardly depends on a linear effect beside it: it is taken off the records as the fit
has it, what is left is searched as any linear bench is, and the law is looked for again beside what was found (a linear
and a nonlinear part in turn, as in Picard's iteration).
"""

from dataclasses import replace

import numpy as np

from modallab.core.progress import part_of_progress
from modallab.gap.conditioning.reduce import select_lines
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.identified import identify_again
from modallab.gap.inference.select import SearchRound, StepwiseSelection
from modallab.gap.model.candidates import beam_candidates
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.forward import forward
from modallab.gap.search.fitting import Bench, fit_at_on_all_data, refitted_without, without_effect
from modallab.gap.search.laws import ROOT, SOFT, law_round
from modallab.twin.bench import Twin
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effects import search_of


def linear_beside_stepped(bench: Bench, fit: Fit) -> SearchRound | None:
    """A linear effect more than a fit whose last effect is stepped in time; None where none helps."""
    without, law = linear_part(bench, fit), fit.problem.candidates[-1].effect
    with part_of_progress(0.0, 0.6):
        level = StepwiseSelection(without, fit_at_on_all_data(without, linear_fit(without, fit))).rounds(1)[0]
    if not level.fits:
        return None
    linear = fit_at_on_all_data(bench, level.fits[0])
    with part_of_progress(0.6, 1.0):
        both = law_round(replace(bench, allowed=law.__eq__), linear, search_of(law).law.overtones)
    # Beside another effect the law may have found a better place: it counts without that effect as well.
    alone = [refitted_without(fit, k) for fit in both.fits[:1] for k in range(len(fit.problem.candidates) - 1)]
    return SearchRound(both.base, (*both.fits, *alone))


def linear_part(bench: Bench, fit: Fit) -> Bench:
    """The bench with what the element adds taken off its records."""
    data = without_element(bench.data, fit.problem.twin(fit.u))
    return replace(bench, data=data, thin=select_lines(data, bench.poles), points=identify_again(bench.points, data))


def without_element(data: Reduced, twin: Twin) -> Reduced:
    """The data less what the element of a twin adds to them."""
    answers = [w - o for w, o in zip(forward(twin, data), forward(replace(twin, element=None), data), strict=True)]
    impacts = tuple(
        replace(d, rows=replace(d.rows, y=d.rows.y - a)) for d, a in zip(data.impacts, answers, strict=False)
    )
    sines = data.sines
    if sines is not None:
        sines = replace(sines, rows=replace(sines.rows, y=sines.rows.y - answers[-1]))
    return replace(data, impacts=impacts, sines=sines)


def linear_fit(bench: Bench, fit: Fit) -> Fit:
    """The fit without the element; the root that it leaves soft becomes a soft root."""
    stepped = fit.problem.candidates[-1]
    own = fit.u[len(fit.u) - len(stepped.slots) :]
    problem, u = without_effect(fit.problem, fit.u, len(fit.problem.candidates) - 1)
    problem = Problem(bench.data, bench.free, problem.candidates)
    if stepped.effect in SOFT:
        root = _soft_root(bench)
        stiffness = stepped.effect_at(own).parameters[SOFT[stepped.effect]]
        problem = replace(problem, candidates=(*problem.candidates, root))
        u = np.append(u, root.slots[0].coordinate(stiffness))
    return Fit(problem, u, float(np.sum(fit.residual**2)), fit.residual, np.eye(len(u)))


def _soft_root(bench: Bench) -> CandidateEffect:
    return next(c for c in beam_candidates(bench.data.rig) if c.effect == ROOT)
