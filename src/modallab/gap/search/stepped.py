"""The search where overtones show that the beam answers out of proportion.

Effects that depend on the size of the motion first; then a linear one beside the best of them; then linear ones alone,
and one that is stepped beside those.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from modallab.core.progress import part_of_progress
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.select import SearchRound, StepwiseSelection
from modallab.gap.model.fit import Fit
from modallab.gap.model.forward import forward
from modallab.gap.model.residual_shares import unexplained
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.search.beside_stepped import linear_beside_stepped
from modallab.gap.search.choose import Selection, effect_names, has_stepped_law, select_explanation
from modallab.gap.search.clock import fit_with_clock
from modallab.gap.search.fitting import Bench, within_tolerances
from modallab.gap.search.laws import law_round
from modallab.gap.search.overtone_check import overtones_closed
from modallab.twin.effect_model import Overtones

MADE = 0.5
"""Share of the overtones that a law must make to be the one."""


@dataclass(frozen=True, eq=False, slots=True)
class _Request:
    """The arguments of `search_stepped`; see there."""

    bench: Bench
    prepared: PreparedCampaign
    base: Fit
    overtones: Overtones
    matters: Reduced | None
    unseen: Reduced
    linear: Callable[[], list[SearchRound]]

    def judged(self, levels: list[SearchRound]) -> Selection:
        """What these rounds say, explained only if the law makes the overtones that were measured."""
        return _with_overtones_checked(select_explanation(self.bench, levels, self.matters), self.prepared, self.unseen)


def search_stepped(
    bench: Bench,
    prepared: PreparedCampaign,
    base: Fit,
    overtones: Overtones,
    matters: Reduced | None,
    unseen: Reduced,
    linear: Callable[[], list[SearchRound]] | None = None,
) -> Selection:
    """What explains a bench that answers out of proportion.

    Args:
        bench: what to search.
        prepared: the records.
        base: the twin without effects.
        overtones: which the records show.
        matters: see `select_explanation`.
        unseen: see `select_explanation`.
        linear: what gives the rounds of linear effects alone, where some are known.
    """
    request = _Request(
        bench, prepared, base, overtones, matters, unseen, linear or StepwiseSelection(bench, base).rounds
    )
    with part_of_progress(0.0, 0.4):
        levels = _stepped_rounds(request)
    first = request.judged(levels)
    if _explains(first) and _nothing_more_matters(first.fit, unseen):
        return first
    with part_of_progress(0.4, 0.6):
        more = linear_beside_stepped(bench, levels[-1].fits[0]) if levels[-1].fits else None
    best = first if more is None else request.judged([*levels, more])
    return best if _explains(best) else _linear_first(request, best, levels[:-1])


def _stepped_rounds(request: _Request) -> list[SearchRound]:
    """The round of stepped effects; before it the clock, where the generator's lines show that it is wrong."""
    clocked = fit_with_clock(request.bench, request.base)
    levels = [] if clocked is None else [SearchRound(request.base, (clocked,))]
    return [*levels, law_round(request.bench, clocked or request.base, request.overtones)]


def _linear_first(request: _Request, first: Selection, clocked: list[SearchRound]) -> Selection:
    """Linear effects, and a stepped one beside the best of them where that is more probable than none."""
    with part_of_progress(0.6, 0.8):
        rounds = request.linear()
    linear = select_explanation(request.bench, rounds, request.matters)
    if linear.explained:
        return linear
    # Beside the clock alone a stepped one has been looked for.
    known = [(), *(effect_names(fit) for level in clocked for fit in level.fits)]
    if effect_names(linear.fit) not in known:
        with part_of_progress(0.8, 1.0):
            last = request.judged([rounds[0], law_round(request.bench, linear.fit, request.overtones)])
        if _explains(last) and has_stepped_law(last.fit):
            return last
    return replace(linear, rivals=(*linear.rivals, *first.rivals))


def _nothing_more_matters(fit: Fit, unseen: Reduced) -> bool:
    """Whether a fit leaves no more than the rig file tolerates, on a bench that is put together as benches are."""
    left = unexplained(unseen, forward(twin_of(fit, unseen), unseen))
    return within_tolerances(fit) and left < unseen.rig.tolerance.response


def _explains(choice: Selection) -> bool:
    """Whether it explains the gap, and does not merely say that what is left does not matter: others may explain it."""
    return choice.explained and choice.tolerated is None


def _with_overtones_checked(choice: Selection, prepared: PreparedCampaign, unseen: Reduced) -> Selection:
    """The same, explained only if the law makes the overtones that were measured."""
    if not choice.explained or not has_stepped_law(choice.fit) or overtones_closed(choice.fit, prepared, unseen) > MADE:
        return choice
    return replace(choice, explained=False)
