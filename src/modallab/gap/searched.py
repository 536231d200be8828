"""What the search says of a campaign: which ways it goes, and in which order."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from modallab.core.progress import part
from modallab.gap.conditioning.prepare import Prepared
from modallab.gap.conditioning.reduce import Reduced
from modallab.gap.report.harmonics import out_of_proportion
from modallab.gap.report.levels import levels_differ, some_levels_differ
from modallab.gap.search.beside_known import beside_known, knows_element
from modallab.gap.search.choose import Choice, choose, stepped
from modallab.gap.search.clock import clock_shows
from modallab.gap.search.explain import explain, rounds
from modallab.gap.search.faint import LITTLE, linear_or_faint
from modallab.gap.search.fitting import Bench, baseline, excess, settled
from modallab.gap.search.one_channel import on_one_channel
from modallab.gap.search.round import Level
from modallab.gap.search.stepped import search_stepped
from modallab.gap.unknown.description import Description, per_number, worth
from modallab.gap.unknown.rival import best_of, channel_alone, near, rivals, unexplained


@dataclass(frozen=True, eq=False, slots=True)
class Searched:
    """What a search has come to.

    Attributes:
        choice: what explains the gap, its numbers settled.
        behaves: what the gap behaves like, best first, where that was seen before all effects were tried.
    """

    choice: Choice
    behaves: tuple[Description, ...] = ()


def searched(
    bench: Bench, prepared: Prepared, matters: Reduced | None, unseen: Reduced, held: Sequence[str]
) -> Searched:
    """What explains the gap.

    Args:
        bench: what to search.
        prepared: the campaign.
        matters: records that no fit has seen, where what does not matter there is no gap; None if all matters.
        unseen: records that no fit has seen.
        held: their names.
    """
    base = baseline(bench)
    if knows_element(base):
        return Searched(_settled(beside_known(bench, base, matters)))
    if base.gap <= bench.flat:
        return Searched(_settled(choose(bench, explain(bench, base), matters)))
    overtones = out_of_proportion(prepared)
    if overtones is not None:
        return Searched(_settled(search_stepped(bench, prepared, base, overtones, matters, unseen)))
    with part(0.0, 0.3):
        first = rounds(bench, base, 1)[0]
    early = _early(bench, prepared, first, matters, unseen, held)
    return early or Searched(_settled(_by_levels(bench, prepared, first, matters, unseen)))


def _early(
    bench: Bench, prepared: Prepared, first: Level, matters: Reduced | None, unseen: Reduced, held: Sequence[str]
) -> Searched | None:
    """What is seen before further rounds: two effects on one channel, or an element without a name; None if neither is.

    A clock that is off lies outside the first round.
    """
    if clock_shows(bench) or not unexplained(bench, prepared, first) or choose(bench, [first], matters).flat:
        return None
    alone = channel_alone(bench, prepared, first, held)
    behaves = rivals(bench, prepared, first, alone, unseen, held)
    if alone is not None and not alone.loses:
        pairs = on_one_channel(bench, alone.fit, alone.row)
        if pairs and near(bench, pairs[0]) and not (behaves and worth(behaves[0]) < per_number(pairs[0])):
            return Searched(_settled(choose(bench, [replace(first, fits=(*pairs, *first.fits))], matters)))
    return Searched(Choice(first.base, first.base, first.fits, False, False), behaves) if behaves else None


def _by_levels(bench: Bench, prepared: Prepared, first: Level, matters: Reduced | None, unseen: Reduced) -> Choice:
    """Linear effects, and where none explains and the levels disagree, those that depend on the size of the motion.

    Overtones drown where a slow mode still rings. Where many levels disagree, one round says whether a linear effect,
    whose transients the twin has wrong, does so; where that leaves less than a half, other linear ones may do the rest.
    """
    base = first.base
    many = levels_differ(base)
    if not (many or some_levels_differ(base)):
        return linear_or_faint(bench, first, matters)
    one_round = many and excess(best_of(first)) > LITTLE * excess(base)
    linear = [first] if one_round else explain(bench, base, first)
    choice = choose(bench, linear, matters)
    if choice.explained and one_round:
        # A round more where it leaves more than the last digit of a large gap.
        further = choose(bench, explain(bench, base, first), matters)
        return further if further.explained else choice
    if choice.explained:
        return choice
    # What answers to the level, not only to the side, makes odd overtones.
    known = partial(explain, bench, base, first) if one_round else lambda: linear
    return search_stepped(bench, prepared, base, "odd", matters, unseen, known)


def _settled(choice: Choice) -> Choice:
    """The same with the fit of linear effects that explain the gap at its very end: their numbers are what is said."""
    if not choice.explained or not choice.fit.problem.candidates or stepped(choice.fit):
        return choice
    return replace(choice, fit=settled(choice.fit))
