"""The kinds of job: identify, report, diagnose, estimate, blind. Each is a few lines over the task itself.

A task is imported where it is computed: whoever hands the jobs out needs none, and a worker only that of its job.
"""

import json
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from pydantic import JsonValue

from modallab.core.block import Campaign
from modallab.core.documents.models import CURVES
from modallab.core.errors import IdentificationError, ModallabError, StorageError
from modallab.core.frozen import Frozen
from modallab.core.hold_out import HoldOut
from modallab.core.plan import Precision
from modallab.core.progress import part_of_progress, report_progress_to
from modallab.formats.atomic import replacing
from modallab.jobs import ComputationResult, JobDefinition, ProgressCallback
from modallab.pipelines.parameters import (
    BlindParameters,
    DiagnoseParameters,
    EstimateParameters,
    IdentifyParameters,
    ReportParameters,
    parse_parameters,
)
from modallab.storage import Store
from modallab.storage.campaigns import campaign_of
from modallab.storage.records import ENDED

RESULTS = "results"
"""Folder of what jobs leave, in the data folder: `results/<attempt>/<file>`."""

Campaigns = Callable[[tuple[str, ...]], Campaign]
Revision = Callable[[tuple[str, ...]], str]
Compared = tuple[Campaign, DiagnoseParameters, Campaign | None]
"""What is diagnosed, how, and what it is held against where that is a campaign from before."""


def kinds(
    campaigns: Campaigns, folder: Path, revision: Revision = lambda _: "", so_far: Campaigns | None = None
) -> tuple[JobDefinition, ...]:
    """All kinds of job.

    Args:
        campaigns: the recordings that a job's inputs name; `campaigns_of(store)` for runs.
        so_far: the same of runs that are still on; `campaigns_of(store, ended=False)`.
        folder: the data folder, where results are kept.
        revision: of what a job's inputs hold; `store.revision` for runs.
    """

    def kind(name: str, compute: Callable[[Any, ProgressCallback], ComputationResult], limit_s: float) -> JobDefinition:
        def load(parameters: dict[str, JsonValue], inputs: tuple[str, ...]) -> tuple[Campaign | None, Frozen]:
            # Blind trials are made, not read.
            return campaigns(inputs) if inputs else None, parse_parameters(name, parameters)

        def keep(attempt: str, computed: ComputationResult) -> JsonValue:
            return {"document": computed.result, "files": _keep_blobs(folder, attempt, computed.blobs)}

        return JobDefinition(name, load, compute, keep, limit_s, revision)

    def load_compared(parameters: dict[str, JsonValue], inputs: tuple[str, ...]) -> Compared:
        asked = DiagnoseParameters.model_validate(parse_parameters("diagnose", parameters))
        today, before = asked.runs_by_session(inputs)
        return campaigns(today), asked, campaigns(before) if before else None

    # While a run goes on its blocks change all the time, and an estimate is of those that are there when it begins.
    estimate = JobDefinition(
        "estimate",
        lambda parameters, inputs: ((so_far or campaigns)(inputs), parse_parameters("estimate", parameters)),
        _estimate,
        lambda _attempt, computed: {"document": computed.result, "files": {}},
        600.0,
    )
    return (
        kind("identify", _identify, 3600.0),
        kind("report", _report, 3600.0),
        replace(kind("diagnose", _diagnose, 4 * 3600.0), load=load_compared),
        estimate,
        kind("blind", _blind, 24 * 3600.0),
    )


def campaigns_of(store: Store, *, ended: bool = True) -> Campaigns:
    """Runs of a data folder, by name, as one campaign; unless `ended` is False none of them may be on."""

    def load(inputs: tuple[str, ...]) -> Campaign:
        if not ended:
            return campaign_of(store, inputs)
        active = [run for run in inputs if store.catalogue.run(run).state not in ENDED]
        if active:
            raise StorageError(
                f"still being recorded: {', '.join(active)}", where=str(store.folder), remedy="wait for the run's end"
            )
        return campaign_of(store, inputs)

    return load


def _identify(payload: tuple[Campaign, IdentifyParameters], notify: ProgressCallback) -> ComputationResult:
    from modallab.pipelines.curves import curves_of
    from modallab.pipelines.model_file import model_document

    campaign, parameters = payload
    with report_progress_to(notify):
        found = parameters.identify(campaign)
    curves = curves_of(campaign, found).model_dump_json().encode()
    return ComputationResult(_plain_document(model_document(campaign, found)), {CURVES: curves})


def _estimate(payload: tuple[Campaign, EstimateParameters], notify: ProgressCallback) -> ComputationResult:
    from modallab.identification.options import IdentificationOptions
    from modallab.pipelines.identify import identify_campaign
    from modallab.pipelines.most_informative_point import most_informative_point

    campaign, _ = payload
    compared = _agreement_of_campaign(campaign)
    names = ("frequency_hz", "frequency_sigma_hz", "damping_ratio", "damping_sigma")
    so_far: dict[str, Any] = {"blocks": len(campaign.blocks), "agreement": compared}
    try:
        with report_progress_to(notify):
            model = identify_campaign(campaign, IdentificationOptions(), None).identified[-1].model
    except IdentificationError:
        # One hit is enough for the comparison, if not for a model.
        if compared is None:
            raise
        return ComputationResult(_plain_document({name: [] for name in names} | so_far | {"telling_point": None}))
    found = json.loads(model.model_dump_json(include=set(names)))
    hits = Counter(b.drive_point for b in campaign.blocks if b.drive_point is not None)
    more = {"telling_point": most_informative_point(model, campaign.rig, hits, Precision())}
    return ComputationResult(_plain_document({name: found[name] for name in names} | so_far | more))


def _agreement_of_campaign(campaign: Campaign) -> dict[str, Any] | None:
    """Whether the simulation agrees with the latest records; None where the rig or the records allow no comparison."""
    from modallab.gap.inference.agreement import agreement, records_of_last_setting

    try:
        found = agreement(records_of_last_setting(campaign))
    except ModallabError:
        return None
    return {"sentence": found.sentence, "agrees": found.agrees, "channels": found.channels}


def _report(payload: tuple[Campaign, ReportParameters], notify: ProgressCallback) -> ComputationResult:
    from modallab.pipelines.model_file import model_document
    from modallab.pipelines.report import report_content
    from modallab.reporting.report import render

    campaign, parameters = payload
    with report_progress_to(notify), part_of_progress(0.0, 0.7):
        result = parameters.identify(campaign)
    notify(0.7, "figures")
    content = report_content(campaign, result, parameters.title or f"Modal test of {campaign.rig.name}")
    return ComputationResult(
        _plain_document(model_document(campaign, result)), {"report.html": render(content).encode()}
    )


def _diagnose(payload: Compared, notify: ProgressCallback) -> ComputationResult:
    from modallab.gap.diagnosis import diagnose
    from modallab.reporting.gap_report import render

    campaign, parameters, before = payload
    if before is not None:
        return _diagnose_by_model(campaign, before, parameters.band_hz, notify)
    with report_progress_to(notify), part_of_progress(0.0, 0.95):
        diagnosis = diagnose(campaign, HoldOut.parse(parameters.hold_out))
    notify(0.95, "figures")
    return ComputationResult(
        json.loads(diagnosis.model_dump_json()), {"gap.html": render(diagnosis, campaign).encode()}
    )


def _diagnose_by_model(
    campaign: Campaign, before: Campaign, band_hz: tuple[float, float] | None, notify: ProgressCallback
) -> ComputationResult:
    from modallab.pipelines.structure_gap import gap_of, model_to_compare
    from modallab.reporting.structure_report import render

    with report_progress_to(notify), part_of_progress(0.0, 0.4):
        reference = model_to_compare(before, band_hz)
    with report_progress_to(notify), part_of_progress(0.4, 0.95):
        gap = gap_of(campaign, reference, f"an earlier campaign, {before.source}", band_hz=band_hz)
    notify(0.95, "figures")
    return ComputationResult(json.loads(gap.diagnosis.model_dump_json()), {"gap.html": render(gap).encode()})


def _blind(payload: tuple[None, BlindParameters], notify: ProgressCallback) -> ComputationResult:
    from modallab.blind.page import render
    from modallab.blind.run import run_blind_trials

    _, parameters = payload
    with report_progress_to(notify), TemporaryDirectory() as folder:
        found = run_blind_trials(Path(folder), parameters)
    return ComputationResult(json.loads(found.model_dump_json()), {"blind.html": render(found).encode()})


def _plain_document(document: Mapping[str, object]) -> JsonValue:
    # Tuples become lists here rather than in the database, so that a result is the same before and after.
    return json.loads(json.dumps(document, allow_nan=False))


def _keep_blobs(folder: Path, attempt: str, blobs: dict[str, bytes]) -> dict[str, JsonValue]:
    if not blobs:
        return {}
    place = folder / RESULTS / attempt
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"cannot be made: {error}", where=str(place), remedy="look at the disk") from error
    for name, content in blobs.items():
        with replacing(place / name) as draft:
            draft.write_bytes(content)
    return {name: f"{RESULTS}/{attempt}/{name}" for name in blobs}
