"""A diagnosis as a document: what a search has found, with the gap before and after it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.block import Block
from modallab.core.diagnosis import (
    CandidateSet,
    Diagnosis,
    Discrepancy,
    FoundEffect,
    Gap,
    ResponseShare,
    Shrinkage,
    Verdict,
)
from modallab.core.digits import percent_text
from modallab.core.effect import place_in_metres
from modallab.core.effects import kind_of
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import ONE_LEVEL, PreparedCampaign
from modallab.gap.conditioning.records import records_as_recorded
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.conditioning.rows import Reduced, Weights
from modallab.gap.model.fit import Fit
from modallab.gap.model.forward import forward
from modallab.gap.model.residual_shares import discrepancies, relative_residuals
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.report.budget import budget_of_gap
from modallab.gap.report.calibrated import calibrated_twin
from modallab.gap.report.contradictions import contradiction_sentences, next_experiment
from modallab.gap.report.effect_inspection import is_in_revisions, noise_share_of_response
from modallab.gap.report.gap_location import gap_location
from modallab.gap.report.initial_gap import squares_as_recorded
from modallab.gap.report.locate import ResidualTestsResult
from modallab.gap.report.measure import (
    name_of_band,
    nearest_mode,
    share_of_gap_closed,
    shares_by_frequency,
    shrinkage_with_interval,
    squared_residuals,
)
from modallab.gap.search.choose import Selection, probabilities
from modallab.gap.search.fitting import Bench, within_tolerances
from modallab.gap.search.intervals import intervals
from modallab.twin.bench import Twin

SEED = 20240501
USUAL = "The rig file states no tolerances: those of an ordinary lab are used; the budget lists them."
TOLERATED = "No effect explains the remaining {} of the response on held-out records; the rig file tolerates this."
LOOSE_ASSEMBLY = "Each parameter is within its tolerance, but all deviations together are improbable."


@dataclass(frozen=True, eq=False, slots=True)
class SearchInput:
    """A campaign made ready for a search.

    Attributes:
        prepared: its records, with the tolerances completed.
        bench: what is searched: the records that are fitted.
        held: names of the records that no fit sees.
        of_unseen: these records; the fitted ones where none are held out.
        everything: all records, reduced.
        unseen: those of `of_unseen`, reduced.
        stated: whether the rig file states tolerances of its own.
    """

    prepared: PreparedCampaign
    bench: Bench
    held: list[str]
    of_unseen: Sequence[Block]
    everything: Reduced
    unseen: Reduced
    stated: bool

    @property
    def rig(self) -> Rig:
        """The rig, its tolerances completed."""
        return self.prepared.campaign.rig

    @property
    def records_that_count(self) -> Reduced | None:
        """Records on which an effect must be of consequence; None where the rig tolerates nothing."""
        return self.unseen if self.rig.tolerance.of_assembly else None


@dataclass(frozen=True, eq=False, slots=True)
class EffectsInRecords:
    """Effects that the records themselves show.

    Attributes:
        named: those whose names may be used.
        seen: of these what does harm and is in no revision of the rig.
        withheld: names that must not be used.
    """

    named: list[FoundEffect]
    seen: list[FoundEffect]
    withheld: list[str]


def document_diagnosis(
    ready: SearchInput, choice: Selection, location: ResidualTestsResult | None, effects: EffectsInRecords
) -> Diagnosis:
    """What was found, as a document."""
    prepared, everything = ready.prepared, ready.everything
    nonlinear = location is not None and location.nonlinear
    ranked, nameless = probabilities(choice)
    found = [*_found_effects(choice, ranked), *effects.seen]
    verdict = _diagnosis_verdict(choice, effects.seen, effects.withheld)
    return Diagnosis(
        rig=ready.rig.name,
        verdict=verdict,
        gap=_gap_document(prepared, choice, everything),
        where=gap_location(verdict, found, effects.withheld, location, choice, everything, prepared),
        effects=sorted(found, key=lambda f: -f.probability) if verdict != "no_gap" else [],
        candidates=_candidates_document(ranked, effects.seen, choice, everything),
        shrink=_shrinkage_document(choice, _held_out_as_recorded(ready, effects.seen), ready.unseen, ready.held),
        next_experiment=next_experiment(verdict, ranked, prepared.campaign, nonlinear, effects.seen),
        twin=calibrated_twin(choice.accepted_fit, everything),
        budget=budget_of_gap(choice.accepted_fit, everything, _resonances_hz(prepared), usual=not ready.stated),
        notes=_diagnosis_notes(ready, choice, effects.named, nonlinear),
        unknown=nameless,
    )


def _diagnosis_notes(ready: SearchInput, choice: Selection, shows: list[FoundEffect], nonlinear: bool) -> list[str]:
    prepared = ready.prepared
    return [
        *([] if ready.stated else [USUAL]),
        *(n for n in prepared.notes if not (nonlinear and n == ONE_LEVEL)),
        *contradiction_sentences(choice, prepared),
        *(d.why for d in choice.dismissed),
        *([] if choice.tolerated is None else [TOLERATED.format(choice.tolerated)]),
        *([LOOSE_ASSEMBLY] if choice.flat and not within_tolerances(choice.base) else []),
        *(
            f"Without consequence: {f.effect.replace('_', ' ')}, "
            f"{percent_text(noise_share_of_response(prepared, f))} of "
            "the response."
            for f in shows
            if is_harmless(prepared, f)
        ),
        *(
            f"Already in the rig's revisions: {f.effect.replace('_', ' ')}."
            for f in shows
            if is_in_revisions(f, prepared.campaign.rig)
        ),
    ]


def is_harmless(prepared: PreparedCampaign, found: FoundEffect) -> bool:
    """Whether an effect that the records show is too small to matter on this rig."""
    tolerance = prepared.campaign.rig.tolerance
    return tolerance.of_assembly and noise_share_of_response(prepared, found) < tolerance.response


def _diagnosis_verdict(choice: Selection, seen: list[FoundEffect], withheld: list[str]) -> Verdict:
    if withheld or not choice.explained:
        return "unknown"
    return "no_gap" if choice.flat and not seen else "known"


def _found_effects(choice: Selection, ranked: list[tuple[Fit, float]]) -> list[FoundEffect]:
    fit = choice.fit
    if not fit.problem.candidates or not choice.explained:
        return []
    length = fit.problem.data.rig.beam.length_m if fit.problem.data.rig.beam is not None else 1.0
    found: list[FoundEffect] = []
    for effect, believed in zip(fit.effects, intervals(fit), strict=True):
        share = sum(p for f, p in ranked if any(c.effect == effect.effect for c in f.problem.candidates))
        found.append(
            FoundEffect(
                effect=effect.effect,
                stage=kind_of(effect.effect).stage,
                probability=float(min(share, 0.995)),
                parameters=effect.parameters,
                interval=believed.within,
                not_known=believed.not_known,
                place=place_in_metres(effect.place, length),
            )
        )
    return found


def _candidates_document(
    ranked: list[tuple[Fit, float]], seen: list[FoundEffect], choice: Selection, data: Reduced
) -> list[CandidateSet]:
    more = [f.effect for f in seen]
    return [
        CandidateSet(
            effects=[*(c.effect for c in f.problem.candidates), *more],
            probability=float(p),
            gap=f.gap,
            fitted=f.effects,
            twin=calibrated_twin(f, data),
        )
        for f, p in ranked[:8]
        # What leaves more than no effect does explains nothing.
        if (f.problem.candidates and f.gap < choice.base.gap) or (more and not f.problem.candidates)
    ]


def _gap_document(prepared: PreparedCampaign, choice: Selection, data: Reduced) -> Gap:
    twin = twin_of(choice.base, data)
    raw = squares_as_recorded(prepared, twin)
    thirds = np.minimum((raw.order * 3).astype(int), 2)
    hz = _resonances_hz(prepared)
    names = [data.rig.channels[c].name for c in raw.channels]
    fitted = twin_of(choice.accepted_fit, data)
    after = squared_residuals(fitted, data)
    return Gap(
        before=raw.gap,
        floor=1.0,
        after=after.gap,
        by_record=raw.by(raw.records),
        by_test=raw.by(raw.tests),
        by_level=raw.by(raw.levels),
        by_channel=raw.by(names),
        after_by_channel=after.by(names),
        by_band=shares_by_frequency(twin, data, name_of_band),
        by_mode=shares_by_frequency(twin, data, nearest_mode(hz)),
        by_order=raw.by([("first third", "middle third", "last third")[i] for i in thirds]),
        poles_hz=hz,
        share_nominal=_gap_in_percent(choice.fit.problem.free.build(np.zeros(choice.fit.problem.free.size)), data, hz),
        share_before=_gap_in_percent(twin, data, hz),
        share_after=_gap_in_percent(fitted, data, hz),
        discrepancy=_model_discrepancy(fitted, data),
    )


def _resonances_hz(prepared: PreparedCampaign) -> list[float]:
    return [float(f) for f in np.abs(prepared.poles) / (2 * np.pi)]


def _gap_in_percent(twin: Twin, data: Reduced, resonances_hz: list[float]) -> ResponseShare:
    at, away = relative_residuals(data, forward(twin, data), np.array(resonances_hz))
    return ResponseShare(at_resonance=at, away=away)


def _model_discrepancy(twin: Twin, data: Reduced) -> Discrepancy | None:
    found = discrepancies(data, forward(twin, data))
    if not found:
        return None
    worst = max(found, key=lambda name: found[name])
    return Discrepancy(median=float(np.median(list(found.values()))), worst=found[worst], record=worst)


def _held_out_as_recorded(ready: SearchInput, seen: list[FoundEffect]) -> Reduced:
    """Records held out, before an explanation: as they came, where that is of the records themselves.

    Noise that the rig file does not promise is no gap that an effect of the twin could close.
    """
    if not seen:
        return ready.unseen
    prepared = ready.prepared
    full_scales = frozenset(m for m in prepared.masked if m[1] not in {c.row for c in prepared.clipped})
    blocks = records_as_recorded(prepared.campaign, ready.of_unseen)
    return reduce_blocks(
        prepared.campaign, blocks, Weights(prepared.believed_v, full_scales, doubt=prepared.driven.doubt)
    )


def _shrinkage_document(choice: Selection, raw: Reduced, clean: Reduced, held: list[str]) -> Shrinkage:
    before = squared_residuals(twin_of(choice.base, clean), raw)
    # The masks of a clipped channel are part of its explanation; the bootstrap pairs entries one by one.
    after = squared_residuals(twin_of(choice.accepted_fit, clean), clean)
    rival = _strongest_rival(choice, clean, before.gap)
    return shrinkage_with_interval(held, before, after, rival, np.random.default_rng(SEED))


def _strongest_rival(choice: Selection, clean: Reduced, before: float) -> dict[str, float]:
    for fit in choice.rivals:
        if before**2 - 1 > 0.02 and fit.problem.candidates:
            after = squared_residuals(twin_of(fit, clean), clean).gap
            # What leaves more than no effect closes nothing.
            return {"+".join(c.effect for c in fit.problem.candidates): max(share_of_gap_closed(before, after), 0.0)}
    return {}
