"""What the newest jobs gave, as typed resources."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from pydantic import ValidationError

from modallab.core.diagnosis import Diagnosis
from modallab.core.documents.models import CURVES, ComparisonView, CurvesView, DiagnosisView, ModelsView, TestModel
from modallab.core.errors import DataError, StorageError
from modallab.core.model import ModalModel
from modallab.jobs import Job
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.jobs.campaign_jobs import campaign_jobs, job_file, none_yet


def models_of_campaign(service: Service, campaign: str) -> ModelsView:
    """The newest models of a campaign.

    Raises:
        NotFoundError: no such campaign, or it has none yet.
    """
    return _models(service, _newest(f"campaign {campaign}", "identify", campaign_jobs(service, campaign, "identify")))


def curves_of_campaign(service: Service, campaign: str) -> CurvesView:
    """What the newest models of a campaign are looked at by.

    Raises:
        NotFoundError: no such campaign, it has no models yet, or they are of a version that left no curves.
    """
    job = _newest(f"campaign {campaign}", "identify", campaign_jobs(service, campaign, "identify"))
    try:
        return CurvesView.model_validate_json(job_file(service, job, CURVES))
    except ValidationError as error:
        raise _unreadable(job) from error


def models_of_run(service: Service, run: str) -> ModelsView:
    """The newest models in which a run has part, best of it alone.

    Raises:
        NotFoundError: no such run in a campaign, or it has none yet.
    """
    jobs = [job for job in jobs_of_run(service, run) if job.kind == "identify"]
    alone = [job for job in jobs if set(job.inputs) == {run} and job.state == "done"]
    return _models(service, _newest(f"run {run}", "identify", alone or jobs))


def jobs_of_run(service: Service, run: str) -> list[Job]:
    """The jobs that work on a run, the one that was ordered last first.

    Raises:
        NotFoundError: no such run in a campaign.
    """
    entry = service.repository.entry(run)
    if entry is None:
        raise NotFoundError(f"there is no run {run!r} in a campaign", remedy="look at the runs of a campaign")
    return [job for job in campaign_jobs(service, entry.campaign) if run in job.inputs]


def diagnosis_of_campaign(service: Service, campaign: str) -> DiagnosisView:
    """The newest diagnosis of a campaign.

    Raises:
        NotFoundError: no such campaign, or it has none yet.
    """
    job = _newest(f"campaign {campaign}", "diagnose", campaign_jobs(service, campaign, "diagnose"))
    try:
        found = Diagnosis.model_validate(_document(job))
    except ValidationError as error:
        raise _unreadable(job) from error
    return DiagnosisView(**_about(service, job), diagnosis=found)


def comparison(service: Service, one: str, other: str) -> ComparisonView:
    """The models of two runs side by side.

    Raises:
        NotFoundError: one of them has no model.
    """
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.identification.selection.pairing import nearest
    from modallab.verification.comparison import compare

    first, second = (_only(models_of_run(service, run), run) for run in (one, other))
    partners = nearest(first.frequency_hz, second.frequency_hz)
    pairs = tuple((i, j) for i, j in enumerate(partners) if j is not None)
    a, b = [i for i, _ in pairs], [j for _, j in pairs]
    hz = np.stack([first.frequency_hz[a], second.frequency_hz[b]], axis=1)
    joint = np.hypot(first.frequency_sigma_hz[a], second.frequency_sigma_hz[b])
    try:
        shapes = compare(first, second)
    except DataError:
        shapes = None
    return ComparisonView(
        runs=(one, other),
        tests=(first.test, second.test),
        modes=pairs,
        frequency_hz=hz,
        difference_percent=100 * (hz[:, 1] / hz[:, 0] - 1),
        sigmas=(hz[:, 1] - hz[:, 0]) / joint,
        damping_ratio=np.stack([first.damping_ratio[a], second.damping_ratio[b]], axis=1),
        mac=None if shapes is None else shapes.mac,
        points=() if shapes is None else shapes.points,
        comac=None if shapes is None else shapes.comac,
        alone=(_others(first, a), _others(second, b)),
    )


def _others(model: ModalModel, paired: Sequence[int]) -> tuple[int, ...]:
    return tuple(i for i in range(model.n_modes) if i not in paired)


def _only(models: ModelsView, run: str) -> ModalModel:
    if not models.models:
        raise NotFoundError(f"run {run} gave no model", where=run, remedy=f"see why at /runs/{run}/model")
    return models.models[-1].model


def _newest(whose: str, kind: str, jobs: Sequence[Job]) -> Job:
    for job in jobs:
        if job.state == "done":
            return job
    raise none_yet(whose, kind, next(iter(jobs), None))


def _models(service: Service, job: Job) -> ModelsView:
    document = _document(job)
    try:
        models = [
            TestModel(
                model=ModalModel.model_validate({key: value for key, value in model.items() if key != "frac"}),
                frac=model["frac"],
                assessment=assessment,
            )
            for model, assessment in zip(document["models"], document["assessments"], strict=True)
        ]
        return ModelsView(**_about(service, job), models=tuple(models), without_model=tuple(document["without_model"]))
    except (ValidationError, KeyError, ValueError) as error:
        raise _unreadable(job) from error


def _about(service: Service, job: Job) -> dict[str, Any]:
    current = not job.revision or job.revision == service.store.revision(job.inputs)
    return {"job": job.id, "runs": job.inputs, "current": current, "code_version": job.code_version}


def _document(job: Job) -> Mapping[str, Any]:
    result = job.result if isinstance(job.result, dict) else {}
    found = result.get("document")
    if not isinstance(found, dict):
        raise _unreadable(job)
    return cast("Mapping[str, Any]", found)


def _unreadable(job: Job) -> StorageError:
    return StorageError(f"the result of job {job.id} cannot be read", where=job.id, remedy="order it again")
