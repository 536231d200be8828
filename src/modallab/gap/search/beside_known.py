"""What else is wrong with a bench of which the rig file knows an effect that is stepped in time.

Each fit of a linear effect beside it would step the known element through all records again, some thousand times. What
the element adds to them hardly depends on a small effect beside it: it is taken off the records as the bench without
any further effect has it, what is left is searched as any linear bench is, and what was found is fitted with the
element in its place (as in `beside_stepped`).
"""

from dataclasses import replace

from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.select import SearchRound, StepwiseSelection
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.model.minimise import minimise
from modallab.gap.search.beside_stepped import linear_part
from modallab.gap.search.choose import Selection, select_explanation
from modallab.gap.search.fitting import Bench

TOGETHER = 2
"""How often the slopes are evaluated where an effect and the element are fitted together."""


def knows_element(base: Fit) -> bool:
    """Whether the twin without further effects has an element that is stepped in time."""
    return base.problem.twin(base.u).element is not None


def linear_beside_known(bench: Bench, base: Fit, matters: Reduced | None) -> Selection:
    """Linear effects beside the element that the rig file knows.

    Args:
        bench: what to search.
        base: the twin without further effects, which has such an element.
        matters: see `select_explanation`.
    """
    linear = replace(linear_part(bench, base), free=replace(bench.free, stepped=False))
    levels = StepwiseSelection(linear, fit_at(Problem(linear.data, linear.free, ()), base.u, base.normal)).rounds()
    return select_explanation(bench, _with_element(bench, base, levels), matters)


def _with_element(bench: Bench, base: Fit, levels: list[SearchRound]) -> list[SearchRound]:
    """The same rounds with the element in its place."""
    found: list[SearchRound] = []
    for level in levels:
        fits = sorted((_fit_with_element(bench, f) for f in level.fits), key=lambda f: f.cost)
        found.append(SearchRound(base, tuple(fits)))
        base = fits[0] if fits else base
    return found


def _fit_with_element(bench: Bench, fit: Fit) -> Fit:
    return minimise(Problem(bench.data, bench.free, fit.problem.candidates), fit.u, TOGETHER, 1e-2)
