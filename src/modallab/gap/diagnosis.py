"""The diagnosis: where the gap lies, what causes it, how far it shrinks."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from modallab.core.blas_threads import one_thread
from modallab.core.block import Campaign
from modallab.core.diagnosis import CandidateSet, Diagnosis
from modallab.core.hold_out import MIXED, HoldOut
from modallab.core.progress import part, report
from modallab.gap.conditioning.prepare import prepare
from modallab.gap.conditioning.reduce import reduce
from modallab.gap.conditioning.split import split
from modallab.gap.documented import SearchInput, ShownEffects, documented, harmless
from modallab.gap.model.nuisances import beam_of
from modallab.gap.model.own_numbers import twin_of
from modallab.gap.model.restored import begin_of
from modallab.gap.model.tolerances import with_tolerances
from modallab.gap.report.initial_gap import bench_of, free_of, weights_of
from modallab.gap.report.inspected import inspected, known_already, shown
from modallab.gap.report.locate import locate
from modallab.gap.search.choose import Choice
from modallab.gap.searched import searched
from modallab.gap.unknown.describe import describe


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
    split(campaign.blocks, hold_out)
    report(0.0, "noise, hum and ring-down")
    ready = _made_ready(campaign, hold_out, allowed, known)
    with part(0.06, 0.7, "search"):
        search = searched(ready.bench, ready.prepared, ready.matters, ready.unseen, ready.held)
    choice = search.choice
    report(0.7, "where the gap lies and what it is made of")
    report(0.72, "location")
    location = None if choice.flat else locate(ready.bench, ready.prepared, choice.base)
    effects = _shown(ready, choice)
    with part(0.8, 0.96, "what it behaves like"):
        described = describe(
            ready.bench, ready.prepared, choice, location, ready.everything, ready.unseen, ready.held, search.behaves
        )
    report(0.96, "budget")
    return documented(ready, choice, location, effects).model_copy(update={"described": described})


def _made_ready(
    campaign: Campaign, hold_out: HoldOut, allowed: Callable[[str], bool], known: Sequence[CandidateSet]
) -> SearchInput:
    prepared = prepare(replace(campaign, rig=with_tolerances(campaign.rig)))
    free = free_of(prepared.campaign)
    fitted, held = split(prepared.blocks, hold_out)
    weights = weights_of(prepared)
    bench = bench_of(prepared, fitted, free, allowed)
    bench = replace(bench, known=tuple(begin_of(c, bench.data, free) for c in known if c.twin is not None))
    unseen = held or fitted
    return SearchInput(
        prepared=prepared,
        bench=bench,
        held=[b.name for b in held],
        of_unseen=unseen,
        everything=reduce(prepared.campaign, prepared.blocks, weights),
        unseen=reduce(prepared.campaign, unseen, weights),
        stated=campaign.rig.tolerance.stated,
    )


def _shown(ready: SearchInput, choice: Choice) -> ShownEffects:
    prepared, allowed = ready.prepared, ready.bench.allowed
    named = [f for f in inspected(prepared, twin_of(choice.believed, ready.everything)) if allowed(f.effect)]
    seen = [f for f in named if not harmless(prepared, f) and not known_already(f, ready.rig)]
    return ShownEffects(named, seen, [name for name in shown(prepared) if not allowed(name)])
