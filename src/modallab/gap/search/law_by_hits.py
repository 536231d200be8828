"""Laws whose overtones drown: a force that grows faster than the motion is felt by hits long before sines show it."""

from dataclasses import replace

from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.select import SearchRound
from modallab.gap.model.fit import Fit
from modallab.gap.search.choose import Selection, has_stepped_law, select_explanation
from modallab.gap.search.clock import fit_with_clock
from modallab.gap.search.fitting import Bench
from modallab.gap.search.laws import law_round
from modallab.twin.effects import search_of


def law_by_hits(bench: Bench, base: Fit, matters: Reduced | None) -> Selection:
    """What such a law says; it must leave as little as a linear effect may.

    Args:
        bench: what to search.
        base: the twin without effects.
        matters: see `select_explanation`.
    """

    def allowed(effect: str) -> bool:
        return bench.allowed(effect) and search_of(effect).law.smooth

    clocked = fit_with_clock(bench, base)
    before = [] if clocked is None else [SearchRound(base, (clocked,))]
    level = law_round(replace(bench, allowed=allowed), clocked or base, "odd")
    choice = select_explanation(bench, [*before, level], matters)
    explained = choice.explained and choice.tolerated is None and has_stepped_law(choice.fit)
    return replace(choice, explained=explained, rivals=choice.rivals if explained else level.fits)
