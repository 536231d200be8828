"""What the newest jobs gave, as typed resources."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from pydantic import ValidationError

from modallab.core.diagnosis import Diagnosis
from modallab.core.documents.models import (
    CURVES,
    ComparisonView,
    CurvesView,
    DiagnosisView,
    ModelsView,
    TestModel,
    TestWithoutModel,
)
from modallab.core.errors import DataError, StorageError
from modallab.core.model import ModalModel
from modallab.core.units import TESTS, Test
from modallab.jobs import Job
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.jobs.campaign_jobs import campaign_jobs, job_file, missing_result_error

if TYPE_CHECKING:
    from modallab.modification.known import KnownStructure


def models_of_campaign(service: Service, campaign: str) -> ModelsView:
    """The newest model of every test of a campaign.

    Raises:
        NotFoundError: no such campaign, or it has none yet.
        StorageError: the newest result cannot be read.
    """
    jobs = campaign_jobs(service, campaign, "identify")
    return _models(service, _newest_by_test(_done_jobs(f"campaign {campaign}", campaign, "identify", jobs)))


def curves_of_campaign(service: Service, campaign: str) -> CurvesView:
    """What the newest models of a campaign are looked at by, in their order.

    Raises:
        NotFoundError: no such campaign, it has no models yet, or they are of a version that left no curves.
        StorageError: a result cannot be read.
    """
    jobs = campaign_jobs(service, campaign, "identify")
    found = _newest_by_test(_done_jobs(f"campaign {campaign}", campaign, "identify", jobs))
    return CurvesView(tests=tuple(_curves(service, one).tests[one.place] for one in found if one.place is not None))


def _curves(service: Service, one: "_NewestResult") -> CurvesView:
    try:
        return CurvesView.model_validate_json(job_file(service, one.job, CURVES))
    except ValidationError as error:
        raise _unreadable_result(one.job) from error


def models_of_run(service: Service, run: str) -> ModelsView:
    """The newest model of every test in which a run has part, best of it alone.

    Raises:
        NotFoundError: no such run in a campaign, or it has none yet.
        StorageError: the newest result cannot be read.
    """
    campaign, found = _jobs_of_run(service, run)
    jobs = [job for job in found if job.kind == "identify"]
    alone = [job for job in jobs if set(job.inputs) == {run} and job.state == "done"]
    return _models(service, _newest_by_test(_done_jobs(f"run {run}", campaign, "identify", alone or jobs)))


def _jobs_of_run(service: Service, run: str) -> tuple[str, list[Job]]:
    entry = service.repository.run_entry(run)
    if entry is None:
        raise NotFoundError(f"there is no run {run!r} in a campaign", remedy="read the list of runs of a campaign")
    return entry.campaign, [job for job in campaign_jobs(service, entry.campaign) if run in job.inputs]


def jobs_of_run(service: Service, run: str) -> list[Job]:
    """The jobs that work on a run, the one that was ordered last first.

    Raises:
        NotFoundError: no such run in a campaign.
    """
    return _jobs_of_run(service, run)[1]


def diagnosis_of_campaign(service: Service, campaign: str) -> DiagnosisView:
    """The newest diagnosis of a campaign.

    Raises:
        NotFoundError: no such campaign, or it has none yet.
    """
    job = _done_jobs(f"campaign {campaign}", campaign, "diagnose", campaign_jobs(service, campaign, "diagnose"))[0]
    try:
        found = Diagnosis.model_validate(_document(job))
    except ValidationError as error:
        raise _unreadable_result(job) from error
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.gap.words.learned import numbers_of_description
    from modallab.gap.words.verdicts import verdict_sentence

    channels = service.store.catalogue.run(job.inputs[0]).rig.channels
    sentence = verdict_sentence(found, [channel.name for channel in channels])
    numbers = numbers_of_description(found.described) if found.described else ()
    return DiagnosisView(**_about_job(service, job), sentence=sentence, numbers=numbers, diagnosis=found)


def comparison_of_runs(service: Service, one: str, other: str) -> ComparisonView:
    """The models of two runs side by side.

    Raises:
        NotFoundError: one of them has no model.
    """
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.identification.selection.criteria import nearest_partners
    from modallab.verification.comparison import compare_shapes

    first, second = (_only_of_run(models_of_run(service, run), run) for run in (one, other))
    partners = nearest_partners(first.frequency_hz, second.frequency_hz)
    pairs = tuple((i, j) for i, j in enumerate(partners) if j is not None)
    a, b = [i for i, _ in pairs], [j for _, j in pairs]
    hz = np.stack([first.frequency_hz[a], second.frequency_hz[b]], axis=1)
    joint = np.hypot(first.frequency_sigma_hz[a], second.frequency_sigma_hz[b])
    try:
        shapes = compare_shapes(first, second)
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
        alone=(_unpaired_modes(first, a), _unpaired_modes(second, b)),
    )


def _unpaired_modes(model: ModalModel, paired: Sequence[int]) -> tuple[int, ...]:
    return tuple(i for i in range(model.n_modes) if i not in paired)


def _only_of_run(models: ModelsView, run: str) -> ModalModel:
    if not models.models:
        raise NotFoundError(f"run {run} gave no model", where=run, remedy=f"see why at /runs/{run}/model")
    return models.models[-1].model


def _done_jobs(whose: str, campaign: str, kind: str, jobs: Sequence[Job]) -> list[Job]:
    found = [job for job in jobs if job.state == "done"]
    if not found:
        raise missing_result_error(whose, campaign, kind, next(iter(jobs), None))
    return found


class _NewestResult(NamedTuple):
    """The newest word on a test: a model at its place in a job's document, or no place and why there is none."""

    job: Job
    test: str | None
    place: int | None
    error: str = ""


def _newest_by_test(jobs: Sequence[Job]) -> list[_NewestResult]:
    """Of done jobs, the newest first, what the newest that speaks of a test says; in the order of the tests.

    Raises:
        StorageError: the newest one cannot be read.
    """
    found: dict[str | None, _NewestResult] = {}
    for job in jobs:
        try:
            said = _tests_of_job(job)
        except StorageError:
            # One of an older version is no reason to hide what is newer.
            if not found:
                raise
            continue
        for one in said:
            found.setdefault(one.test, one)
    order = {test: n for n, test in enumerate(TESTS)}
    return sorted(found.values(), key=lambda one: order.get(cast("Test", one.test), len(order)))


def _tests_of_job(job: Job) -> list[_NewestResult]:
    document = _document(job)
    try:
        models = [_NewestResult(job, model["test"], n) for n, model in enumerate(document["models"])]
        return models + [_NewestResult(job, one["test"], None, one["error"]) for one in document["without_model"]]
    except (KeyError, TypeError) as error:
        raise _unreadable_result(job) from error


def _models(service: Service, found: Sequence[_NewestResult]) -> ModelsView:
    models = tuple(_model(service, one.job, one.place) for one in found if one.place is not None)
    without = tuple(TestWithoutModel(test=str(one.test), error=one.error) for one in found if one.place is None)
    newest = max((one.job for one in found), key=lambda job: job.created_utc)
    abouts = [_about_job(service, one.job) for one in found]
    return ModelsView(
        job=newest.id,
        runs=tuple(dict.fromkeys(run for about in abouts for run in about["runs"])),
        current=all(about["current"] for about in abouts),
        code_version=newest.code_version,
        models=models,
        without_model=without,
    )


def _model(service: Service, job: Job, place: int) -> TestModel:
    document = _document(job)
    try:
        model = document["models"][place]
        about = {key: value for key, value in _about_job(service, job).items() if key != "code_version"}
        return TestModel(
            **about,
            model=ModalModel.model_validate({key: value for key, value in model.items() if key != "frac"}),
            frac=model["frac"],
            assessment=document["assessments"][place],
        )
    except (ValidationError, KeyError, IndexError) as error:
        raise _unreadable_result(job) from error


def _about_job(service: Service, job: Job) -> dict[str, Any]:
    current = not job.revision or job.revision == service.store.revision(job.inputs)
    return {"job": job.id, "runs": job.inputs, "current": current, "code_version": job.code_version}


def _document(job: Job) -> Mapping[str, Any]:
    result = job.result if isinstance(job.result, dict) else {}
    found = result.get("document")
    if not isinstance(found, dict):
        raise _unreadable_result(job)
    return cast("Mapping[str, Any]", found)


def _unreadable_result(job: Job) -> StorageError:
    return StorageError(f"the result of job {job.id} cannot be read", where=job.id, remedy="order it again")


KEPT = 8
"""Models that stay ready for use: their samples take longer than what is asked of them."""
_READY: dict[tuple[str, Test | None, tuple[str, ...]], "KnownStructure"] = {}


def known_of_campaign(service: Service, campaign: str, test: Test | None) -> "KnownStructure":
    """The newest model of a test, ready for use; of the first test if none is named.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: no driving point, or a point that is not known.
    """
    from modallab.modification.known import KnownStructure

    found = model_of_campaign(service, campaign, test)
    key = (found.job, found.model.test, found.runs)
    if key in _READY:
        return _READY[key]
    known = KnownStructure(found.model, service.store.catalogue.run(found.runs[0]).rig)
    while len(_READY) >= KEPT:
        _READY.pop(next(iter(_READY)))
    return _READY.setdefault(key, known)


def model_of_campaign(service: Service, campaign: str, test: Test | None) -> TestModel:
    """The newest model of a test; of the first test if none is named.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
    """
    there = models_of_campaign(service, campaign).models
    for one in there:
        if test in (None, one.model.test):
            return one
    raise NotFoundError(
        f"campaign {campaign} has no model of {'any' if test is None else 'the ' + test} test",
        where="test",
        remedy=f"there are: {', '.join(str(one.model.test) for one in there) or 'none'}",
    )
