"""Work on a campaign: ordered once, remembered with the campaign, and the files it leaves."""

from modallab.core.documents.results import JobKind, JobRequest
from modallab.core.errors import JobError, StorageError, split_remedy
from modallab.jobs import Job
from modallab.pipelines.parameters import parse_parameters
from modallab.service.context import Service
from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.records import audit
from modallab.service.records.archive import ArchivedRecords
from modallab.storage.records import ENDED


def order_job(service: Service, campaign: str, kind: JobKind, new: JobRequest, operator: str) -> Job:
    """Order a job on runs of a campaign.

    Raises:
        NotFoundError: no such campaign, or a run that is not of it.
        ConflictError: no run that could be used, or the campaign is archived or deleted.
        JobError: parameters that cannot be kept.
    """
    ArchivedRecords(service.engine).require_present(campaign)
    runs = _runs(service, campaign, new.runs)
    parse_parameters(kind, new.parameters)
    job = service.jobs.submit(kind, dict(new.parameters), runs, service.store.revision(runs))
    service.repository.add_job(campaign, job, operator)
    return job


def order_estimate(service: Service, run: str, operator: str) -> Job:
    """Order the modes of a run as far as it has come.

    Raises:
        NotFoundError: no such run in a campaign.
        ConflictError: the run has no good block yet, or the campaign is archived or deleted.
    """
    entry = service.repository.run_entry(run)
    if entry is None:
        raise NotFoundError(f"there is no run {run!r} in a campaign", remedy="read the list of runs of a campaign")
    ArchivedRecords(service.engine).require_present(entry.campaign)
    if not _counts(service, run):
        raise ConflictError("the run has no good block yet", where=run, remedy="wait for the first good block")
    job = service.jobs.submit("estimate", {"as_of": service.store.revision((run,))}, (run,))
    service.repository.add_job(entry.campaign, job, operator)
    return job


def order_blind(service: Service, new: JobRequest, operator: str) -> Job:
    """Order blind trials, and keep who did.

    Raises:
        JobError: runs were named, or parameters that cannot be kept.
    """
    if new.runs is not None:
        raise JobError("blind trials have no input runs", where="runs", remedy="leave `runs` out")
    parse_parameters("blind", new.parameters)
    job = service.jobs.submit("blind", dict(new.parameters), ())
    audit.enter_action(service.engine, operator, "order-blind", job.id, {"job": job.id, "runs": []})
    return job


def campaign_jobs(service: Service, campaign: str, kind: str | None = None) -> list[Job]:
    """The jobs of a campaign, the newest first, with their results.

    Raises:
        NotFoundError: no such campaign.
    """
    service.repository.campaign(campaign)
    return [service.jobs.get(name) for name in service.repository.jobs(campaign, kind)]


def _runs(service: Service, campaign: str, requested: tuple[str, ...] | None) -> tuple[str, ...]:
    # One that is archived is used where it is named, one that is deleted nowhere.
    known = service.repository.runs(campaign, archived=requested is not None)
    foreign = [run for run in requested or () if run not in known]
    if foreign:
        raise NotFoundError(
            f"campaign {campaign} has no run {foreign[0]!r}", where="runs", remedy="read the list of its runs"
        )
    records = [service.store.catalogue.run(run) for run in requested or known]
    going_on = [record.id for record in records if record.state not in ENDED]
    if requested and going_on:
        raise ConflictError(f"run {going_on[0]} is active", where="runs", remedy="wait for its end")
    ended = (record.id for record in records if record.state in ENDED and record.valid)
    usable = tuple(run for run in ended if _counts(service, run))
    if not usable:
        raise ConflictError("there is no ended, valid run with good blocks", where=campaign, remedy="record one first")
    return usable


def _counts(service: Service, run: str) -> bool:
    return any(block.note.accepted for block in service.store.catalogue.blocks(run))


_NOUN = {"diagnose": "diagnosis", "identify": "model"}
_RESOURCE = {"diagnose": "diagnoses", "identify": "models", "report": "reports"}


def newest_file(service: Service, campaign: str, kind: str, name: str) -> bytes:
    """The file of the newest job of a kind that is done.

    Raises:
        NotFoundError: no such campaign, or no such job is done.
        StorageError: the file cannot be read.
    """
    jobs = campaign_jobs(service, campaign, kind)
    for job in jobs:
        if job.state == "done":
            return job_file(service, job, name)
    raise missing_result_error(f"campaign {campaign}", campaign, kind, next(iter(jobs), None))


def missing_result_error(whose: str, campaign: str, kind: str, newest: Job | None) -> NotFoundError:
    """What to raise where no job of a kind is done; `newest` is one that is not."""
    noun, order_at = _NOUN.get(kind, kind), f"POST to /api/v1/campaigns/{campaign}/{_RESOURCE[kind]}"
    if newest is None:
        return NotFoundError(f"{whose} has no {noun}", where=whose, remedy=f"order one by a {order_at}, and wait")
    why, known = split_remedy(newest.error or "")
    remedy = known or (
        f"order the job again by a {order_at}" if newest.has_ended else f"wait until job {newest.id} has ended"
    )
    said = f"the {noun} of {whose} is {newest.state}{': ' if why else ''}{why}"
    return NotFoundError(said, where=whose, remedy=remedy)


def job_file(service: Service, job: Job, name: str) -> bytes:
    """A file that a job left.

    Raises:
        NotFoundError: it left none of this name.
        StorageError: the file cannot be read.
    """
    result = job.result if isinstance(job.result, dict) else {}
    files = result.get("files")
    place = files.get(name) if isinstance(files, dict) else None
    if not isinstance(place, str):
        raise NotFoundError(f"job {job.id} left no file {name!r}", where=job.id, remedy="read its result")
    try:
        return (service.folder / place).read_bytes()
    except OSError as error:
        raise StorageError(f"cannot be read: {error.strerror}", where=place, remedy="order it again") from error
