"""Which effects explain the data: round after round, each effect fitted with the nuisances and with those before.

Forward selection (Draper and Smith, Applied Regression Analysis, 1998), all numbers fitted again in each round.
"""

from dataclasses import replace

import numpy as np

from modallab.core.progress import part
from modallab.gap.model.fit import Fit, Problem, seen
from modallab.gap.search.beside_hits import beside_the_hits, only_hits, only_sines
from modallab.gap.search.by_frequencies import round_by_frequencies
from modallab.gap.search.by_relief import round_by_relief
from modallab.gap.search.clock import with_clock
from modallab.gap.search.elsewhere import elsewhere
from modallab.gap.search.fitting import (
    Bench,
    baseline,
    completed,
    excess,
    on_all,
    ordinary,
    plausible,
    rested,
    unbent,
)
from modallab.gap.search.round import Level, round_of

WORTH = 0.9
"""A further effect must leave less than this share of what was left, or the search ends."""
HOLDS = 0.15
"""An effect stays if without it more than this share of the gap would come back."""
NEARLY = 0.01
"""Share of the first excess that counts as nearly explained."""
SECOND = 0.3
"""The same from the second round on."""
SOLVED = 1.3
"""Times the floor at which a search is done."""
SOLVED_SHARE = 0.003
"""Share of the first excess at which it is done as well."""
LAST_DIGIT = 2.5e-4
"""Where thousands of noise units are explained, what is left of this share is the last digit of either model."""
YIELDS = 0.05
"""Share of the first excess below which the two tests together yield something: the hits alone would not part more."""
AFTER = 0.4
"""Share of the work that is left after a round, as far as anybody knows before it."""
MOST = 3
"""Effects in one diagnosis."""


def explain(bench: Bench, base: Fit | None = None, begun: Level | None = None) -> list[Level]:
    """Round after round until nothing is left, or no further effect helps; if that fails, once more from either test.

    Args:
        bench: what to search.
        base: the twin without effects, if it is known.
        begun: the first round from there, if it is known.
    """
    with part(0.0, 0.7):
        levels = first_rounds(bench, base or baseline(bench), begun)
    if _solved(bench, levels) or bench.data.sines is None or not bench.data.impacts:
        return levels
    if bench.free.deviations and excess(_best(levels)) < YIELDS * excess(levels[0].base):
        return levels
    for begin, only, test in ((0.7, only_hits, "hits"), (0.85, only_sines, "sines")):
        with part(begin, begin + 0.15, f"{test} alone"):
            again = _from_one_test(bench, levels[0].base, only(bench))
        levels = again if again and _best(again).cost < 0.5 * _best(levels).cost else levels
        if _solved(bench, levels):
            break
    return levels


def first_rounds(bench: Bench, base: Fit, begun: Level | None = None) -> list[Level]:
    """All rounds; where the generator's own lines show a wrong clock, with that clock from the start.

    Beside another effect the beam takes such a clock over, and none of the later rounds would find its way back.
    """
    clocked = with_clock(bench, base)
    if clocked is None:
        return rounds(bench, base, MOST, begun)
    return [Level(base, (clocked,)), *rounds(bench, clocked, MOST - 1)]


def rounds(bench: Bench, base: Fit, most: int, begun: Level | None = None) -> list[Level]:
    """At most so many rounds from a fit, of which the first may be known."""
    levels: list[Level] = []
    first = base.gap
    while len(levels) < most and (base.gap > _ends(bench, first, levels) or (not levels and _impossible(bench, base))):
        # Each round is seldom followed by another.
        with part(1 - AFTER ** len(levels), 1 - AFTER ** (len(levels) + 1), f"round {len(levels) + 1}"):
            level = _level(bench, base) if levels or begun is None else begun
            level = level if base.problem.candidates else with_known(bench, level)
        levels.append(level)
        # Once nearly all is explained, a further effect must be worth its name to go on from.
        worth = WORTH if excess(base) > NEARLY * excess(levels[0].base) else HOLDS
        if len(levels) > 1:
            # Two effects hide each other; once both are there, the rest must fall.
            worth = min(worth, SECOND)
        if not level.fits or excess(level.fits[0]) > worth * excess(base):
            break
        base = level.fits[0]
    return levels or [Level(base, ())]


def with_known(bench: Bench, level: Level) -> Level:
    """A first round with what an earlier diagnosis had left standing, fitted from its own numbers."""
    begun = [completed(bench, seen(Problem(bench.data, bench.free, p.candidates), u)) for p, u in bench.known]
    known = [elsewhere(f) for f in begun]
    return replace(level, fits=tuple(sorted([*level.fits, *known], key=lambda f: f.cost)))


def _ends(bench: Bench, first: float, levels: list[Level]) -> float:
    """Rms residual at which no further round is worth it: of a search that began with that of `first`."""
    return bench.flat + LAST_DIGIT * first if levels else bench.watched


def _level(bench: Bench, base: Fit) -> Level:
    """One round from a fit; where a little bent too far hides all effects, once more from the assembly at rest."""
    beside = None if base.problem.candidates or ordinary(base) else beside_the_hits(bench)
    if beside is not None:
        return Level(base, (beside,))
    begin = rested(bench, base)
    hidden = begin is base and _impossible(bench, base)
    found: list[Level] = []
    for hidden_round in (round_by_relief, round_by_frequencies) if hidden else ():
        found.append(hidden_round(bench, base))
        if any(map(ordinary, found[-1].fits)):
            return found[-1]
    # Where nothing is left to see, the assembly has done all of the work, and no first order says more.
    if found and base.gap <= bench.watched:
        return min(found, key=_least)
    found.append(replace(round_of(bench, begin, before=base.gap), base=base))
    if hidden and not any(map(ordinary, found[-1].fits)):
        found.append(replace(round_of(bench, unbent(bench, base), before=base.gap), base=base))
    return min(found, key=_least)


def _least(level: Level) -> float:
    return min((f.cost for f in level.fits), default=np.inf)


def _impossible(bench: Bench, base: Fit) -> bool:
    """Whether a fit has bent a number of the assembly beyond what its tolerance may be."""
    return bool(bench.free.deviations) and not plausible(base)


def _from_one_test(bench: Bench, base: Fit, only: Bench) -> list[Level]:
    """The rounds from what explains one of the two tests alone; none if nothing does.

    What hangs on the shaker does not disturb the hits, and hits beside their points do not disturb the sines.
    """
    started = from_one_test(bench, only)
    if started is None:
        return []
    later = rounds(bench, started, MOST - len(started.problem.candidates))
    return [Level(base, (started,)), *later] if started.problem.candidates else later


def from_one_test(bench: Bench, only: Bench) -> Fit | None:
    """What explains the records of one test alone, on all data. None if nothing explains them."""
    levels = rounds(only, baseline(only), 1)
    return on_all(bench, _best(levels)) if _solved(only, levels) else None


def _best(levels: list[Level]) -> Fit:
    return min((f for level in levels for f in (level.base, *level.fits)), key=lambda f: f.cost)


def _solved(bench: Bench, levels: list[Level]) -> bool:
    """Whether next to nothing is left."""
    best = _best(levels)
    return best.gap <= bench.flat * SOLVED or excess(best) < SOLVED_SHARE * excess(levels[0].base)
