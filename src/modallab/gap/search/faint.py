"""Laws whose overtones drown: a force that grows faster than the motion is felt by hits long before sines show it."""

from dataclasses import replace

import numpy as np

from modallab.gap.conditioning.reduce import Reduced
from modallab.gap.model.fit import Fit
from modallab.gap.search.choose import Choice, choose, stepped
from modallab.gap.search.clock import with_clock
from modallab.gap.search.explain import explain
from modallab.gap.search.fitting import Bench, excess
from modallab.gap.search.nonlinear import nonlinear_level
from modallab.gap.search.round import Level
from modallab.twin.effects import search_of

LITTLE = 0.5
"""Share of the gap that a linear effect must leave for these laws to be tried before further linear ones."""


def linear_or_faint(bench: Bench, begun: Level, matters: Reduced | None) -> Choice:
    """Linear effects, and such laws where none explains: first of all where the best linear one explains little.

    Args:
        bench: what to search.
        begun: the first round of linear effects.
        matters: see `choose`.
    """
    base = begun.base
    little = min((excess(f) for f in begun.fits), default=np.inf) > LITTLE * excess(base)
    early = little and not choose(bench, [begun], matters).explained
    tried = _faint(bench, base, matters) if early else None
    if tried is not None and tried.explained:
        return tried
    choice = choose(bench, explain(bench, base, begun), matters)
    if choice.explained:
        return choice
    tried = tried or _faint(bench, base, matters)
    return tried if tried.explained else replace(choice, rivals=(*choice.rivals, *tried.rivals))


def _faint(bench: Bench, base: Fit, matters: Reduced | None) -> Choice:
    """What such a law says; it must leave as little as a linear effect may."""

    def allowed(effect: str) -> bool:
        return bench.allowed(effect) and search_of(effect).drowns

    clocked = with_clock(bench, base)
    before = [] if clocked is None else [Level(base, (clocked,))]
    level = nonlinear_level(replace(bench, allowed=allowed), clocked or base, "odd")
    choice = choose(bench, [*before, level], matters)
    explained = choice.explained and choice.calm is None and stepped(choice.fit)
    return replace(choice, explained=explained, rivals=choice.rivals if explained else level.fits)
