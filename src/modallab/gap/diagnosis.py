"""The diagnosis: where the gap lies, what causes it, how far it shrinks."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.blas_threads import one_thread
from modallab.core.block import Block, Campaign
from modallab.core.diagnosis import CandidateSet, Diagnosis, Discrepancy, Found, Gap, Percent, Shrink, Verdict
from modallab.core.digits import percent
from modallab.core.effects import kind_of
from modallab.core.hold_out import MIXED, HoldOut
from modallab.core.places import in_metres
from modallab.core.progress import part, report
from modallab.gap.conditioning.prepare import ONE_LEVEL, Prepared, prepare
from modallab.gap.conditioning.records import as_recorded
from modallab.gap.conditioning.reduce import reduce
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.conditioning.split import split
from modallab.gap.conditioning.weights import Weights
from modallab.gap.model.fit import Fit
from modallab.gap.model.forward import forward
from modallab.gap.model.nuisances import beam_of
from modallab.gap.model.own_numbers import twin_of
from modallab.gap.model.restored import begin_of
from modallab.gap.model.share import discrepancies, left
from modallab.gap.model.tolerances import with_tolerances
from modallab.gap.report.budget import budget
from modallab.gap.report.calibrated import calibrated
from modallab.gap.report.contradictions import contradictions
from modallab.gap.report.initial_gap import as_came, bench_of, free_of, weights_of
from modallab.gap.report.inspected import harm, inspected, known_already, shown
from modallab.gap.report.locate import locate
from modallab.gap.report.measure import band_of, by_frequency, nearest_mode, squares
from modallab.gap.report.next_step import next_experiment
from modallab.gap.report.shrinkage import closed, shrink
from modallab.gap.report.where import where
from modallab.gap.search.choose import Choice, probabilities
from modallab.gap.search.fitting import ordinary
from modallab.gap.search.intervals import intervals
from modallab.gap.searched import searched
from modallab.gap.unknown.describe import describe
from modallab.twin.bench import Twin

Array = NDArray[np.float64]

SEED = 20240501
USUAL = "The rig file states no tolerances: a lab's usual ones stand for them; the budget lists them."
TOLERATED = "No effect explains the remaining {} of the response on held-out records; the rig file tolerates them."
LOOSE_ASSEMBLY = (
    "Together, the parameters of the assembly deviate more than the tolerances of the rig; none does alone."
)


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
    stated = campaign.rig.tolerance.stated
    prepared = prepare(replace(campaign, rig=with_tolerances(campaign.rig)))
    campaign = prepared.campaign
    free = free_of(campaign)
    fitted, held = split(prepared.blocks, hold_out)
    weights = weights_of(prepared)
    bench = bench_of(prepared, fitted, free, allowed)
    bench = replace(bench, known=tuple(begin_of(c, bench.data, free) for c in known if c.twin is not None))
    everything = reduce(campaign, prepared.blocks, weights)
    unseen = reduce(campaign, held or fitted, weights)
    matters = unseen if campaign.rig.tolerance.of_assembly else None
    with part(0.06, 0.7, "search"):
        search = searched(bench, prepared, matters, unseen, [b.name for b in held])
    choice = search.choice
    report(0.7, "where the gap lies and what it is made of")
    report(0.72, "location")
    location = None if choice.flat else locate(bench, prepared, choice.base)
    nonlinear = location is not None and location.nonlinear
    shows = [f for f in inspected(prepared, twin_of(choice.believed, everything)) if allowed(f.effect)]
    seen = [f for f in shows if not _harmless(prepared, f) and not known_already(f, campaign.rig)]
    # Effects the records show but whose names must not be used.
    withheld = [name for name in shown(prepared) if not allowed(name)]
    ranked = probabilities(choice)
    found = [*_found(choice, ranked), *seen]
    verdict = _verdict(choice, seen, withheld)
    with part(0.8, 0.96, "what it behaves like"):
        names = [b.name for b in held]
        described = describe(bench, prepared, choice, location, everything, unseen, names, search.behaves)
    report(0.96, "budget")
    return Diagnosis(
        rig=campaign.rig.name,
        verdict=verdict,
        gap=_gap(campaign, prepared, choice, everything),
        where=where(verdict, found, withheld, location, choice, everything, prepared),
        effects=sorted(found, key=lambda f: -f.probability) if verdict != "no_gap" else [],
        candidates=_candidates(ranked, seen, choice, everything),
        shrink=_shrink(choice, _as_found(prepared, seen, unseen, held or fitted), unseen, [b.name for b in held]),
        next_experiment=next_experiment(verdict, ranked, campaign, nonlinear),
        twin=calibrated(choice.believed, everything),
        budget=budget(choice.believed, everything, _resonances_hz(prepared), usual=not stated),
        notes=_notes(prepared, choice, shows, stated, nonlinear),
        described=described,
    )


def _notes(prepared: Prepared, choice: Choice, shows: list[Found], stated: bool, nonlinear: bool) -> list[str]:
    return [
        *([] if stated else [USUAL]),
        *(n for n in prepared.notes if not (nonlinear and n == ONE_LEVEL)),
        *contradictions(choice, prepared),
        *(d.why for d in choice.dismissed),
        *([] if choice.tolerated is None else [TOLERATED.format(choice.tolerated)]),
        *([LOOSE_ASSEMBLY] if choice.flat and not ordinary(choice.base) else []),
        *(
            f"Does no harm: {f.effect.replace('_', ' ')}, {percent(harm(prepared, f))} of the response."
            for f in shows
            if _harmless(prepared, f)
        ),
        *(
            f"As the rig's revisions know: {f.effect.replace('_', ' ')}."
            for f in shows
            if known_already(f, prepared.campaign.rig)
        ),
    ]


def _harmless(prepared: Prepared, found: Found) -> bool:
    tolerance = prepared.campaign.rig.tolerance
    return tolerance.of_assembly and harm(prepared, found) < tolerance.response


def _verdict(choice: Choice, seen: list[Found], withheld: list[str]) -> Verdict:
    if withheld or not choice.explained:
        return "unknown"
    return "no_gap" if choice.flat and not seen else "known"


def _found(choice: Choice, ranked: list[tuple[Fit, float]]) -> list[Found]:
    fit = choice.fit
    if not fit.problem.candidates or not choice.explained:
        return []
    length = fit.problem.data.rig.beam.length_m if fit.problem.data.rig.beam is not None else 1.0
    found: list[Found] = []
    for effect, believed in zip(fit.effects, intervals(choice), strict=True):
        share = sum(p for f, p in ranked if any(c.effect == effect.effect for c in f.problem.candidates))
        found.append(
            Found(
                effect=effect.effect,
                stage=kind_of(effect.effect).stage,
                probability=float(min(share, 0.995)),
                parameters=effect.parameters,
                interval=believed.within,
                not_known=believed.not_known,
                place=in_metres(effect.place, length),
            )
        )
    return found


def _candidates(
    ranked: list[tuple[Fit, float]], seen: list[Found], choice: Choice, data: Reduced
) -> list[CandidateSet]:
    more = [f.effect for f in seen]
    listed = [
        CandidateSet(
            effects=[*(c.effect for c in f.problem.candidates), *more],
            probability=float(p),
            gap=f.gap,
            fitted=f.effects,
            twin=calibrated(f, data),
        )
        for f, p in ranked[:8]
        # What leaves more than no effect does explains nothing.
        if (f.problem.candidates and f.gap < choice.base.gap) or (more and not f.problem.candidates)
    ]
    if not choice.explained:
        listed = [c.model_copy(update={"probability": c.probability * 0.3}) for c in listed]
    return listed


def _gap(campaign: Campaign, prepared: Prepared, choice: Choice, data: Reduced) -> Gap:
    twin = twin_of(choice.base, data)
    raw = as_came(prepared, twin)
    thirds = np.minimum((raw.order * 3).astype(int), 2)
    hz = _resonances_hz(prepared)
    names = [campaign.rig.channels[c].name for c in raw.channels]
    fitted = twin_of(choice.believed, data)
    after = squares(fitted, data)
    return Gap(
        before=raw.gap,
        floor=1.0,
        after=after.gap,
        by_record=raw.by(raw.records),
        by_test=raw.by(raw.tests),
        by_level=raw.by(raw.levels),
        by_channel=raw.by(names),
        after_by_channel=after.by(names),
        by_band=by_frequency(twin, data, band_of),
        by_mode=by_frequency(twin, data, nearest_mode(hz)),
        by_order=raw.by([("first third", "middle third", "last third")[i] for i in thirds]),
        poles_hz=hz,
        share_nominal=_percent(choice.fit.problem.free.build(np.zeros(choice.fit.problem.free.size)), data, hz),
        share_before=_percent(twin, data, hz),
        share_after=_percent(fitted, data, hz),
        discrepancy=_discrepancy(fitted, data),
    )


def _resonances_hz(prepared: Prepared) -> list[float]:
    return [float(f) for f in np.abs(prepared.poles) / (2 * np.pi)]


def _percent(twin: Twin, data: Reduced, resonances_hz: list[float]) -> Percent:
    at, away = left(data, forward(twin, data), np.array(resonances_hz))
    return Percent(at_resonance=at, away=away)


def _discrepancy(twin: Twin, data: Reduced) -> Discrepancy | None:
    found = discrepancies(data, forward(twin, data))
    if not found:
        return None
    worst = max(found, key=lambda name: found[name])
    return Discrepancy(median=float(np.median(list(found.values()))), worst=found[worst], record=worst)


def _as_found(prepared: Prepared, seen: list[Found], clean: Reduced, held: Sequence[Block]) -> Reduced:
    """Records held out, before an explanation: as they came, where that is of the records themselves.

    Noise that the rig file does not promise is no gap that an effect of the twin could close.
    """
    if not seen:
        return clean
    full_scales = frozenset(m for m in prepared.masked if m[1] not in {c.row for c in prepared.clipped})
    blocks = as_recorded(prepared.campaign, held)
    return reduce(prepared.campaign, blocks, Weights(prepared.believed_v, full_scales, doubt=prepared.driven.doubt))


def _shrink(choice: Choice, raw: Reduced, clean: Reduced, held: list[str]) -> Shrink:
    before = squares(twin_of(choice.base, clean), raw)
    # The masks of a clipped channel are part of its explanation; the bootstrap pairs entries one by one.
    after = squares(twin_of(choice.believed, clean), clean)
    rival = _rival(choice, clean, before.gap)
    return shrink(held, before, after, rival, np.random.default_rng(SEED))


def _rival(choice: Choice, clean: Reduced, before: float) -> dict[str, float]:
    for fit in choice.rivals:
        if before**2 - 1 > 0.02 and fit.problem.candidates:
            after = squares(twin_of(fit, clean), clean).gap
            # What leaves more than no effect closes nothing.
            return {"+".join(c.effect for c in fit.problem.candidates): max(closed(before, after), 0.0)}
    return {}
