"""The diagnosis: where the gap lies, what causes it, how far it shrinks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from modallab.core.blas_threads import one_thread
from modallab.core.block import Campaign
from modallab.core.diagnosis import CandidateSet, Diagnosis
from modallab.core.hold_out import MIXED, HoldOut
from modallab.core.progress import part_of_progress, report_progress
from modallab.gap.conditioning.prepare import PreparedCampaign, prepare_campaign
from modallab.gap.conditioning.records import split_held_out
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.diagnosis_document import EffectsInRecords, SearchInput, document_diagnosis, is_harmless
from modallab.gap.inference.agreement import agreement_of
from modallab.gap.inference.baseline import without_effects
from modallab.gap.inference.select import StepwiseSelection
from modallab.gap.model.fit import Fit, fit_at
from modallab.gap.model.nuisances import beam_of
from modallab.gap.model.restored import start_from_diagnosis
from modallab.gap.model.tolerances import with_tolerances
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.report.effect_inspection import effects_on_records, inspect_effects, is_in_revisions
from modallab.gap.report.harmonics import channels_out_of_proportion, levels_differ
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records, weights_of
from modallab.gap.report.locate import locate_gap
from modallab.gap.search.beside_known import knows_element, linear_beside_known
from modallab.gap.search.choose import Selection, select_explanation
from modallab.gap.search.clock import clock_error_visible
from modallab.gap.search.fitting import Bench, converged_fit, leaves_noise_only
from modallab.gap.search.law_by_hits import law_by_hits
from modallab.gap.search.stepped import search_stepped
from modallab.gap.unknown.describe import describe
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

    choice: Selection
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
    base = converged_fit(bench, fit_at(found.problem, found.u))
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
    choice = select_explanation(bench, selection.rounds(), matters)
    if choice.flat or _leaves_nothing(bench, prepared, choice):
        return SearchOutcome(choice)
    behaves = () if clock_error_visible(bench) else unnamed_explanations(bench, prepared, choice, alone, unseen, held)
    if behaves:
        nameless = unnamed_evidence(behaves[0])
        return SearchOutcome(Selection(base, base, choice.named, False, False, nameless=nameless), behaves)
    if choice.explained or alone is not None:
        return SearchOutcome(choice)
    return SearchOutcome(_search_nonlinear(bench, prepared, selection, choice, matters, unseen))


def _leaves_nothing(bench: Bench, prepared: PreparedCampaign, choice: Selection) -> bool:
    """Whether named effects leave nothing that an element without a name could explain better."""
    return choice.explained and leaves_noise_only(bench, choice.fit) and not loses_samples(prepared, choice.fit)


def _search_nonlinear(
    bench: Bench,
    prepared: PreparedCampaign,
    selection: StepwiseSelection,
    linear: Selection,
    matters: Reduced | None,
    unseen: Reduced,
) -> Selection:
    """Laws that depend on the size of the motion: their overtones may drown where a slow mode still rings."""
    base: Fit = linear.base
    if levels_differ(base):
        # What answers to the level, not only to the side, makes odd overtones.
        return search_stepped(bench, prepared, base, "odd", matters, unseen, selection.rounds)
    law = law_by_hits(bench, base, matters)
    return law if law.explained else replace(linear, rivals=(*linear.rivals, *law.rivals))


@one_thread()
def diagnose(
    campaign: Campaign,
    hold_out: HoldOut = MIXED,
    allowed: Callable[[str], bool] = lambda _: True,
    known: Sequence[CandidateSet] = (),
) -> Diagnosis:
    """Diagnose a campaign.

    Args:
        campaign: the records, with the rig as believed.
        hold_out: which records no fit may see.
        allowed: whether an effect of this name may be used; for trials in which one is withheld.
        known: explanations that a diagnosis of some of these records has left: their numbers are places to begin from.

    Raises:
        DataError: there is nothing to diagnose, or a known explanation has an effect that no fit looks for.
        RigError: the rig has no beam.
        PlanError: the rule leaves nothing to fit.
    """
    # First of all: without one no record is of use, whatever else it lacks.
    beam_of(campaign.rig)
    split_held_out(campaign.blocks, hold_out)
    report_progress(0.0, "noise, hum and ring-down")
    ready = _made_ready(campaign, hold_out, allowed, known)
    with part_of_progress(0.06, 0.7, "search"):
        search = search_explanation(ready.bench, ready.prepared, ready.records_that_count, ready.unseen, ready.held)
    choice = search.choice
    report_progress(0.7, "location and budget of the gap")
    report_progress(0.72, "location")
    location = None if choice.flat else locate_gap(ready.bench, ready.prepared, choice.base)
    effects = _effects_on_records(ready, choice)
    with part_of_progress(0.8, 0.96, "description of an unnamed cause"):
        described = describe(
            ready.bench, ready.prepared, choice, location, ready.everything, ready.unseen, ready.held, search.behaves
        )
    report_progress(0.96, "budget")
    return document_diagnosis(ready, choice, location, effects).model_copy(update={"described": described})


def _made_ready(
    campaign: Campaign, hold_out: HoldOut, allowed: Callable[[str], bool], known: Sequence[CandidateSet]
) -> SearchInput:
    prepared = prepare_campaign(replace(campaign, rig=with_tolerances(campaign.rig)))
    free = nuisances_of_campaign(prepared.campaign)
    fitted, held = split_held_out(prepared.blocks, hold_out)
    weights = weights_of(prepared)
    bench = problem_of_records(prepared, fitted, free, allowed)
    bench = replace(bench, known=tuple(start_from_diagnosis(c, bench.data, free) for c in known if c.twin is not None))
    unseen = held or fitted
    return SearchInput(
        prepared=prepared,
        bench=bench,
        held=[b.name for b in held],
        of_unseen=unseen,
        everything=reduce_blocks(prepared.campaign, prepared.blocks, weights),
        unseen=reduce_blocks(prepared.campaign, unseen, weights),
        stated=campaign.rig.tolerance.stated,
    )


def _effects_on_records(ready: SearchInput, choice: Selection) -> EffectsInRecords:
    prepared, allowed = ready.prepared, ready.bench.allowed
    named = [f for f in inspect_effects(prepared, twin_of(choice.accepted_fit, ready.everything)) if allowed(f.effect)]
    seen = [f for f in named if not is_harmless(prepared, f) and not is_in_revisions(f, ready.rig)]
    return EffectsInRecords(named, seen, [name for name in effects_on_records(prepared) if not allowed(name)])
