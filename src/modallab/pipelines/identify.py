"""Identifies every test of a campaign and verifies each model."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from modallab.core.blas_threads import one_thread
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, IdentificationError, ModallabError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel, Verification
from modallab.core.progress import part_of_progress, report_progress
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND, Broadband, Test
from modallab.frf.broadband import driven_band
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.frf.periodic_drive import resample_blocks_to_drive_clock
from modallab.frf.stepped import stepped_frf
from modallab.identification.backbone import DriveLevel
from modallab.identification.frf_model import frf_in_band, identify_given_frf
from modallab.identification.impact import LEAK, default_band, identify_impact
from modallab.identification.model.modal_mass import with_scale
from modallab.identification.odd_hits import agreeing_hits
from modallab.identification.options import IdentificationOptions
from modallab.identification.sine import identify_sine
from modallab.pipelines.assess import assess_broadband, assess_frf, assess_impact, assess_sine
from modallab.pipelines.averaged_frfs import frf_of_drive, identify_averaged_hits, identify_drive
from modallab.pipelines.levels import (
    IdentifiedTest,
    Source,
    group_by_level,
    group_by_strength,
    is_linear,
    model_of_weakest_level,
    weakest_hits,
)
from modallab.pipelines.undamaged_records import undamaged_records
from modallab.signals.drive_kind import check_kind
from modallab.signals.signals import Signals, to_signals_of
from modallab.verification.assessment import ModelAssessment, doubtful_mode_sentences, mismatch_warning
from modallab.verification.verify import verify_frf, verify_impact, verify_sine


@dataclass(frozen=True, eq=False, slots=True)
class UnidentifiedTest:
    """A test that gave no model, and why."""

    source: Source
    error: ModallabError


@dataclass(frozen=True, eq=False, slots=True)
class CampaignResult:
    """What a campaign gave: models, and tests without one."""

    identified: tuple[IdentifiedTest, ...]
    unidentified: tuple[UnidentifiedTest, ...]


@one_thread()
def identify_campaign(
    campaign: Campaign,
    options: IdentificationOptions,
    test: Test | None = None,
    ahead: Mapping[Source, Callable[[], IdentifiedTest]] | None = None,
) -> CampaignResult:
    """Models of every test in a campaign, or of one.

    Args:
        campaign: blocks or FRFs, and the rig.
        options: method, band, order.
        test: only this test.
        ahead: tests that are being identified elsewhere already; each returns its model once it is there.

    Returns:
        models, and what a test without one died of: one bad test does not take the other with it.

    Raises:
        DataError: nothing to identify, or damaged records, when no test gave a model.
        IdentificationError: no test holds a mode.
    """
    found: list[IdentifiedTest] = []
    failed: list[UnidentifiedTest] = []
    runs = _tests_to_identify(campaign, options, test)
    for n, (source, run) in enumerate(runs):
        try:
            with part_of_progress(n / len(runs), (n + 1) / len(runs), f"{source} test"):
                found.append(_with_scale((ahead or {}).get(source, run)(), campaign.rig))
        except ModallabError as error:
            failed.append(UnidentifiedTest(source, error))
    if not found and failed:
        raise failed[0].error
    if not found:
        raise DataError(
            "the campaign has no blocks" if test is None else f"there is no block of a {test} test",
            where=campaign.source,
            remedy="check that the campaign holds records of a test",
        )
    return CampaignResult(tuple(found), tuple(failed))


def _tests_to_identify(
    campaign: Campaign, options: IdentificationOptions, test: Test | None
) -> list[tuple[Source, Callable[[], IdentifiedTest]]]:
    runs: list[tuple[Source, Callable[[], IdentifiedTest]]] = []
    if campaign.of("impact") and test in (None, "impact"):
        runs.append(("impact", lambda: _identify_impact(campaign, campaign.of("impact"), options)))
    if campaign.of("sine") and test in (None, "sine"):
        runs.append(("sine", lambda: _identify_sine(campaign, campaign.of("sine"), options)))
    runs.extend(
        (signal, partial(_identify_broadband, campaign, signal, options))
        for signal in BROADBAND
        if campaign.of(signal) and test in (None, signal)
    )
    if test is None:
        runs.extend(("frf", partial(_identify_frf, campaign, i, options)) for i in range(len(campaign.frfs)))
    return runs


def usable_blocks(campaign: Campaign, blocks: tuple[Block, ...]) -> tuple[list[Signals], Rig, tuple[str, ...]]:
    """The sound part of the blocks in SI units, the rig with its channels only, and notes on what was left out.

    Records whose force is not that of the test they are labelled as are left out as well, and so are hits that do not
    answer as the others at their point.

    Raises:
        DataError: damaged samples, no block is left, or most are of another kind of test.
        RigError: no force was measured.
    """
    _ = campaign.rig.force_channel
    clean, rig, notes = undamaged_records(campaign, blocks)
    kept, remarks = check_kind(to_signals_of(clean, rig))
    if all(block.test == "impact" for block in clean):
        kept, odd = agreeing_hits(kept)
        remarks = (*remarks, *odd)
    return kept, rig, (*notes, *remarks)


def _with_scale(found: IdentifiedTest, rig: Rig) -> IdentifiedTest:
    return replace(found, model=with_scale(found.model, rig))


def _with_notes(model: ModalModel, notes: tuple[str, ...]) -> ModalModel:
    return model.model_copy(update={"notes": (*notes, *model.notes)})


def _with_doubts(
    source: Source, model: ModalModel, verification: Verification, assessment: ModelAssessment, index: int = 0
) -> IdentifiedTest:
    """With what is to be doubted of it among its notes."""
    doubted = (*doubtful_mode_sentences(model, assessment.confidence), *mismatch_warning(model, verification.frac))
    noted = model.model_copy(update={"notes": (*model.notes, *doubted)})
    return IdentifiedTest(source, noted, verification, assessment, index)


def _identify_impact(campaign: Campaign, blocks: tuple[Block, ...], options: IdentificationOptions) -> IdentifiedTest:
    signals, rig, notes = usable_blocks(campaign, blocks)
    groups = group_by_point(signals)
    own_model = options.own_model
    if own_model is not None:
        frf = impact_frf(groups, rig, options.band_hz or default_band(groups), estimator=options.frf)
        return IdentifiedTest("impact", _with_notes(own_model(frf, "impact"), notes), None)
    if options.frf != "H1":
        model, fit, frf = identify_averaged_hits(groups, rig, options)
        return _with_doubts("impact", _with_notes(model, notes), verify_frf(model, frf), assess_frf(model, fit, frf))
    pooled, error = _try_identify(lambda: _model_of_hits(signals, notes, rig, options))
    if pooled is not None and is_linear(pooled):
        return pooled
    band = options.band_hz or default_band(groups)
    shift = float(np.log(LEAK) * signals[0].rate_hz / signals[0].force.size)

    def level(name: str, parts: list[list[Signals]]) -> DriveLevel:
        hits = [hit for group in parts for hit in group]
        whole, *each = (impact_frf(one, rig, band, damping_shift=shift) for one in (parts, *([[hit]] for hit in hits)))
        return DriveLevel(name, whole, hits, each)

    levels = [level(name, parts) for name, parts in group_by_strength(groups)]
    found = model_of_weakest_level(
        pooled, levels, lambda o: _model_of_hits(weakest_hits(groups), notes, rig, o), options
    )
    return _require_model(found, error)


def _try_identify(identify: Callable[[], IdentifiedTest]) -> tuple[IdentifiedTest | None, ModallabError | None]:
    """A model, or why there is none: that of records of several levels may be none where one level gives one."""
    try:
        return identify(), None
    except IdentificationError as error:
        return None, error


def _require_model(found: IdentifiedTest | None, error: ModallabError | None) -> IdentifiedTest:
    if found is None:
        raise error or IdentificationError("no mode was found", remedy="look at the FRFs")
    return found


def _model_of_hits(
    signals: list[Signals], notes: tuple[str, ...], rig: Rig, options: IdentificationOptions
) -> IdentifiedTest:
    groups = group_by_point(signals)
    with part_of_progress(0.05, 0.9):
        model, fit = identify_impact(signals, rig, options)
    report_progress(0.9, "assessment")
    assessment = assess_impact(model, fit, groups, rig)
    verification = verify_impact(model, fit, groups, rig)
    return _with_doubts("impact", _with_notes(model, notes), verification, assessment)


def _identify_sine(campaign: Campaign, blocks: tuple[Block, ...], options: IdentificationOptions) -> IdentifiedTest:
    _require_averaged(options, "an FRF of sines is the ratio of two fitted amplitudes")
    signals, rig, notes = usable_blocks(campaign, blocks)
    own_model = options.own_model
    if own_model is not None:
        low, high = options.band_hz or (0.0, float("inf"))
        frf = stepped_frf([s for s in signals if low <= s.tone.frequency_hz <= high], rig)
        return IdentifiedTest("sine", _with_notes(own_model(frf, "sine"), notes), None)
    with part_of_progress(0.05, 0.9):
        model, fit = identify_sine(signals, rig, options)
    report_progress(0.9, "assessment")
    assessment = assess_sine(model, fit, signals, rig)
    verification = verify_sine(model, fit, signals, rig)
    return _with_doubts("sine", _with_notes(model, notes), verification, assessment)


def _identify_broadband(campaign: Campaign, test: Broadband, options: IdentificationOptions) -> IdentifiedTest:
    every, rig, notes = usable_blocks(campaign, campaign.of(test))
    every = resample_blocks_to_drive_clock(every, options.band_hz or driven_band(every))
    band = options.band_hz or driven_band(every)
    frf = frf_of_drive(every, rig, band, options.frf)
    own_model = options.own_model
    if own_model is not None:
        return IdentifiedTest(test, _with_notes(own_model(frf, test), notes), None)
    pooled, error = _try_identify(lambda: _model_of_drive(test, every, frf, notes, rig, options))
    if pooled is not None and is_linear(pooled):
        return pooled
    parts = group_by_level(every)
    levels = [DriveLevel(n, frf_of_drive(s, rig, band, options.frf), s) for n, s in parts] if len(parts) > 1 else []
    found = model_of_weakest_level(
        pooled, levels, lambda o: _model_of_drive(test, parts[0][1], levels[0].frf, notes, rig, o), options
    )
    return _require_model(found, error)


def _model_of_drive(
    test: Broadband, signals: list[Signals], frf: Frf, notes: tuple[str, ...], rig: Rig, options: IdentificationOptions
) -> IdentifiedTest:
    found, fit, frf = identify_drive(signals, frf, rig, options)
    model = found.model_copy(update={"test": test})
    assessment = assess_broadband(model, fit, signals, frf, rig)
    return _with_doubts(test, _with_notes(model, notes), verify_frf(model, frf), assessment)


def _identify_frf(campaign: Campaign, index: int, options: IdentificationOptions) -> IdentifiedTest:
    _require_averaged(options, "the FRFs were imported")
    frf = campaign.frfs[index]
    own_model = options.own_model
    if own_model is not None:
        return IdentifiedTest("frf", own_model(frf_in_band(frf, options.band_hz), None), None, index=index)
    model, fit = identify_given_frf(frf, campaign.rig, options)
    assessment = assess_frf(model, fit, frf)
    return _with_doubts("frf", model, verify_frf(model, frf), assessment, index)


def _require_averaged(options: IdentificationOptions, why: str) -> None:
    if options.frf != "H1":
        raise DataError(f"{options.frf} is not available: {why}", remedy="leave the kind of FRF out, or give H1")
