"""Laws whose overtones drown: a force that grows faster than the motion is felt by hits long before sines show it."""

from dataclasses import replace

from modallab.gap.conditioning.reduce import Reduced
from modallab.gap.model.fit import Fit
from modallab.gap.search.choose import Choice, choose, stepped
from modallab.gap.search.clock import with_clock
from modallab.gap.search.fitting import Bench
from modallab.gap.search.nonlinear import nonlinear_level
from modallab.gap.search.round import Level
from modallab.twin.effects import search_of


def faint(bench: Bench, base: Fit, linear: Choice, matters: Reduced | None) -> Choice:
    """What such a law explains where nothing linear does; it must leave as little as a linear effect may.

    Args:
        bench: what was searched.
        base: the twin without effects.
        linear: what the rounds of linear effects say.
        matters: see `choose`.
    """

    def allowed(effect: str) -> bool:
        return bench.allowed(effect) and search_of(effect).drowns

    clocked = with_clock(bench)
    before = [] if clocked is None else [Level(base, (clocked,), ())]
    level = nonlinear_level(replace(bench, allowed=allowed), clocked or base, "odd")
    choice = choose(bench, [*before, level], matters)
    if choice.explained and choice.calm is None and stepped(choice.fit):
        return choice
    return replace(linear, rivals=(*linear.rivals, *level.fits))
