"""What explains a campaign's gap: linear effects, laws that are stepped in time, elements without a name."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.agreement import agreement_of
from modallab.gap.inference.baseline import without_effects
from modallab.gap.inference.select import StepwiseSelection
from modallab.gap.model.fit import Fit, evaluated
from modallab.gap.report.harmonics import channels_out_of_proportion
from modallab.gap.report.levels import levels_differ
from modallab.gap.search.beside_known import knows_element, linear_beside_known
from modallab.gap.search.choose import Choice, choose
from modallab.gap.search.clock import clock_error_visible
from modallab.gap.search.fitting import Bench, converged, leaves_noise_only
from modallab.gap.search.law_by_hits import law_by_hits
from modallab.gap.search.stepped import search_stepped
from modallab.gap.unknown.description import Description
from modallab.gap.unknown.rival import (
    lone_channel,
    loses_samples,
    unnamed_evidence,
    unnamed_explanations,
)


@dataclass(frozen=True, eq=False, slots=True)
class SearchOutcome:
    """What a search has come to.

    Attributes:
        choice: what explains the gap.
        behaves: what the gap behaves like, best first, where that was seen before all effects were tried.
    """

    choice: Choice
    behaves: tuple[Description, ...] = ()


def search_explanation(
    bench: Bench, prepared: PreparedCampaign, matters: Reduced | None, unseen: Reduced, held: Sequence[str]
) -> SearchOutcome:
    """What explains the gap.

    Args:
        bench: what to search.
        prepared: the campaign.
        matters: held-out records, where what does not matter there is no gap; None if all matters.
        unseen: held-out records.
        held: their names.
    """
    view, found = without_effects(bench)
    base = converged(bench, evaluated(found.problem, found.u))
    if knows_element(base):
        return SearchOutcome(linear_beside_known(bench, base, matters))
    overtones = channels_out_of_proportion(prepared) if base.gap > bench.flat else None
    if overtones is not None:
        return SearchOutcome(search_stepped(bench, prepared, base, overtones, matters, unseen))
    agreement = agreement_of(bench, view, found)
    alone = lone_channel(bench, prepared, agreement, held) if base.gap > bench.flat else None
    if alone is not None:
        # Where all others agree with a sound bench, the cause stands in this channel.
        bench = replace(bench, row=alone.row)
    selection = StepwiseSelection(bench, base)
    choice = choose(bench, selection.rounds(), matters)
    if choice.flat or _leaves_nothing(bench, prepared, choice):
        return SearchOutcome(choice)
    behaves = () if clock_error_visible(bench) else unnamed_explanations(bench, prepared, choice, alone, unseen, held)
    if behaves:
        nameless = unnamed_evidence(behaves[0])
        return SearchOutcome(Choice(base, base, choice.named, False, False, nameless=nameless), behaves)
    if choice.explained or alone is not None:
        return SearchOutcome(choice)
    return SearchOutcome(_search_nonlinear(bench, prepared, selection, choice, matters, unseen))


def _leaves_nothing(bench: Bench, prepared: PreparedCampaign, choice: Choice) -> bool:
    """Whether named effects leave nothing that an element without a name could explain better."""
    return choice.explained and leaves_noise_only(bench, choice.fit) and not loses_samples(prepared, choice.fit)


def _search_nonlinear(
    bench: Bench,
    prepared: PreparedCampaign,
    selection: StepwiseSelection,
    linear: Choice,
    matters: Reduced | None,
    unseen: Reduced,
) -> Choice:
    """Laws that depend on the size of the motion: their overtones may drown where a slow mode still rings."""
    base: Fit = linear.base
    if levels_differ(base):
        # What answers to the level, not only to the side, makes odd overtones.
        return search_stepped(bench, prepared, base, "odd", matters, unseen, selection.rounds)
    law = law_by_hits(bench, base, matters)
    return law if law.explained else replace(linear, rivals=(*linear.rivals, *law.rivals))
