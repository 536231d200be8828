"""Identifies every test of a campaign and verifies each model."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from modallab.core.blas_threads import one_thread
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, IdentificationError, ModallabError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.progress import part, report
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND, Broadband, Test
from modallab.core.verification import Verification
from modallab.frf.broadband import driven_band
from modallab.frf.driven import on_own_clock
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.frf.stepped import stepped_frf
from modallab.identification.backbone import DriveLevel
from modallab.identification.frf_model import identify_given_frf, in_band
from modallab.identification.impact import LEAK, default_band, identify_impact
from modallab.identification.model.scale import with_scale
from modallab.identification.options import Options
from modallab.identification.sine import identify_sine
from modallab.pipelines.assess import assess_broadband, assess_frf, assess_impact, assess_sine
from modallab.pipelines.averaged_hits import identify_averaged_hits
from modallab.pipelines.drive import frf_of_drive, identify_drive
from modallab.pipelines.levels import Identified, Source, by_level, by_strength, linear, of_weakest, softest
from modallab.pipelines.sound import sound
from modallab.signals.drive_kind import check_kind
from modallab.signals.signals import Signals, to_signals_of
from modallab.verification.assessment import Assessment
from modallab.verification.reservations import doubts, mismatch_warning
from modallab.verification.verify import verify_frf, verify_impact, verify_sine


@dataclass(frozen=True, eq=False, slots=True)
class Unidentified:
    """A test that gave no model, and why."""

    source: Source
    error: ModallabError


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What a campaign gave: models, and tests without one."""

    identified: tuple[Identified, ...]
    unidentified: tuple[Unidentified, ...]


@one_thread()
def identify_campaign(
    campaign: Campaign,
    options: Options,
    test: Test | None = None,
    ahead: Mapping[Source, Callable[[], Identified]] | None = None,
) -> Result:
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
    found: list[Identified] = []
    failed: list[Unidentified] = []
    runs = _runs(campaign, options, test)
    for n, (source, run) in enumerate(runs):
        try:
            with part(n / len(runs), (n + 1) / len(runs), f"{source} test"):
                found.append(_with_scale((ahead or {}).get(source, run)(), campaign.rig))
        except ModallabError as error:
            failed.append(Unidentified(source, error))
    if not found and failed:
        raise failed[0].error
    if not found:
        raise DataError(
            "there is no block to identify" if test is None else f"there is no block of a {test} test",
            where=campaign.source,
            remedy="check that the campaign holds records of a test",
        )
    return Result(tuple(found), tuple(failed))


def _runs(campaign: Campaign, options: Options, test: Test | None) -> list[tuple[Source, Callable[[], Identified]]]:
    runs: list[tuple[Source, Callable[[], Identified]]] = []
    if campaign.of("impact") and test in (None, "impact"):
        runs.append(("impact", lambda: _impact(campaign, campaign.of("impact"), options)))
    if campaign.of("sine") and test in (None, "sine"):
        runs.append(("sine", lambda: _sine(campaign, campaign.of("sine"), options)))
    runs.extend(
        (signal, partial(_broadband, campaign, signal, options))
        for signal in BROADBAND
        if campaign.of(signal) and test in (None, signal)
    )
    if test is None:
        runs.extend(("frf", partial(_frf, campaign, i, options)) for i in range(len(campaign.frfs)))
    return runs


def usable(campaign: Campaign, blocks: tuple[Block, ...]) -> tuple[list[Signals], tuple[str, ...]]:
    """The blocks in SI units without those at full scale or with faults in their samples, and a note on these.

    Those whose force is not that of the test they are labelled as are left out as well.

    Raises:
        DataError: damaged samples, no block is left, or most are of another kind of test.
    """
    clean, notes = sound(campaign, blocks, campaign.rig.force_channel.name)
    kept, remarks = check_kind(to_signals_of(clean, campaign.rig))
    return kept, (*notes, *remarks)


def _with_scale(found: Identified, rig: Rig) -> Identified:
    return replace(found, model=with_scale(found.model, rig))


def _with_notes(model: ModalModel, notes: tuple[str, ...]) -> ModalModel:
    return model.model_copy(update={"notes": (*notes, *model.notes)})


def _judged(
    source: Source, model: ModalModel, verification: Verification, assessment: Assessment, index: int = 0
) -> Identified:
    """With what is to be doubted of it among its notes."""
    doubted = (*doubts(model, assessment.confidence), *mismatch_warning(model, verification.frac))
    noted = model.model_copy(update={"notes": (*model.notes, *doubted)})
    return Identified(source, noted, verification, assessment, index)


def _impact(campaign: Campaign, blocks: tuple[Block, ...], options: Options) -> Identified:
    signals, notes = usable(campaign, blocks)
    groups = group_by_point(signals)
    own_model = options.own_model
    if own_model is not None:
        frf = impact_frf(groups, campaign.rig, options.band_hz or default_band(groups), estimator=options.frf)
        return Identified("impact", _with_notes(own_model(frf, "impact"), notes), None)
    if options.frf != "H1":
        model, fit, frf = identify_averaged_hits(groups, campaign.rig, options)
        return _judged("impact", _with_notes(model, notes), verify_frf(model, frf), assess_frf(model, fit, frf))
    pooled, error = _tried(lambda: _of_hits(signals, notes, campaign.rig, options))
    if pooled is not None and linear(pooled):
        return pooled
    band = options.band_hz or default_band(groups)
    shift = float(np.log(LEAK) * signals[0].rate_hz / signals[0].force.size)
    levels = [
        DriveLevel(name, impact_frf(parts, campaign.rig, band, damping_shift=shift), [s for p in parts for s in p])
        for name, parts in by_strength(groups)
    ]
    found = of_weakest(pooled, levels, lambda o: _of_hits(softest(groups), notes, campaign.rig, o), options)
    return _there(found, error)


def _tried(identify: Callable[[], Identified]) -> tuple[Identified | None, ModallabError | None]:
    """A model, or why there is none: that of records of several levels may be none where one level gives one."""
    try:
        return identify(), None
    except IdentificationError as error:
        return None, error


def _there(found: Identified | None, error: ModallabError | None) -> Identified:
    if found is None:
        raise error or IdentificationError("no mode was found", remedy="look at the FRFs")
    return found


def _of_hits(signals: list[Signals], notes: tuple[str, ...], rig: Rig, options: Options) -> Identified:
    groups = group_by_point(signals)
    with part(0.05, 0.9):
        model, fit = identify_impact(signals, rig, options)
    report(0.9, "assessment")
    assessment = assess_impact(model, fit, groups, rig)
    verification = verify_impact(model, fit, groups, rig)
    return _judged("impact", _with_notes(model, notes), verification, assessment)


def _sine(campaign: Campaign, blocks: tuple[Block, ...], options: Options) -> Identified:
    _require_averaged(options, "a sine's FRF is the ratio of two fitted amplitudes")
    signals, notes = usable(campaign, blocks)
    own_model = options.own_model
    if own_model is not None:
        low, high = options.band_hz or (0.0, float("inf"))
        frf = stepped_frf([s for s in signals if low <= s.tone.frequency_hz <= high], campaign.rig)
        return Identified("sine", _with_notes(own_model(frf, "sine"), notes), None)
    with part(0.05, 0.9):
        model, fit = identify_sine(signals, campaign.rig, options)
    report(0.9, "assessment")
    assessment = assess_sine(model, fit, signals, campaign.rig)
    verification = verify_sine(model, fit, signals, campaign.rig)
    return _judged("sine", _with_notes(model, notes), verification, assessment)


def _broadband(campaign: Campaign, test: Broadband, options: Options) -> Identified:
    every, notes = usable(campaign, campaign.of(test))
    every = on_own_clock(every, options.band_hz or driven_band(every))
    band = options.band_hz or driven_band(every)
    frf = frf_of_drive(every, campaign.rig, band, options.frf)
    own_model = options.own_model
    if own_model is not None:
        return Identified(test, _with_notes(own_model(frf, test), notes), None)
    pooled, error = _tried(lambda: _of_drive(test, every, frf, notes, campaign.rig, options))
    if pooled is not None and linear(pooled):
        return pooled
    parts = by_level(every)
    levels = (
        [DriveLevel(n, frf_of_drive(s, campaign.rig, band, options.frf), s) for n, s in parts] if len(parts) > 1 else []
    )
    found = of_weakest(
        pooled, levels, lambda o: _of_drive(test, parts[0][1], levels[0].frf, notes, campaign.rig, o), options
    )
    return _there(found, error)


def _of_drive(
    test: Broadband, signals: list[Signals], frf: Frf, notes: tuple[str, ...], rig: Rig, options: Options
) -> Identified:
    found, fit, frf = identify_drive(signals, frf, rig, options)
    model = found.model_copy(update={"test": test})
    assessment = assess_broadband(model, fit, signals, frf, rig)
    return _judged(test, _with_notes(model, notes), verify_frf(model, frf), assessment)


def _frf(campaign: Campaign, index: int, options: Options) -> Identified:
    _require_averaged(options, "these FRFs are made already")
    frf = campaign.frfs[index]
    own_model = options.own_model
    if own_model is not None:
        return Identified("frf", own_model(in_band(frf, options.band_hz), None), None, index=index)
    model, fit = identify_given_frf(frf, campaign.rig, options)
    assessment = assess_frf(model, fit, frf)
    return _judged("frf", model, verify_frf(model, frf), assessment, index)


def _require_averaged(options: Options, why: str) -> None:
    if options.frf != "H1":
        raise DataError(f"there is no {options.frf} to be had: {why}", remedy="leave the kind of FRF out, or give H1")
