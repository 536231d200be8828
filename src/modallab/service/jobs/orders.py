"""Work on a campaign: ordered once, remembered with the campaign."""

from sqlalchemy import select

from modallab.core.documents.results import JobKind, JobNew
from modallab.jobs import Job
from modallab.pipelines.parameters import parse_parameters
from modallab.service.context import Service
from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.records.campaign_jobs import remember
from modallab.service.records.database import reading
from modallab.storage.records import ENDED
from modallab.storage.service_tables import CAMPAIGN_JOBS


def order(service: Service, campaign: str, kind: JobKind, new: JobNew, operator: str) -> Job:
    """Order a job on runs of a campaign.

    Raises:
        NotFoundError: no such campaign, or a run that is not of it.
        ConflictError: no run that could be used.
        JobError: parameters that cannot be kept.
    """
    runs = _runs(service, campaign, new.runs)
    parse_parameters(kind, new.parameters)
    job = service.jobs.submit(kind, dict(new.parameters), runs)
    remember(service.store.catalogue.engine, campaign, job, operator)
    return job


def campaign_jobs(service: Service, campaign: str, kind: str | None = None) -> list[Job]:
    """The jobs of a campaign, the newest first.

    Raises:
        NotFoundError: no such campaign.
    """
    service.repository.campaign(campaign)
    query = select(CAMPAIGN_JOBS.c.job).where(CAMPAIGN_JOBS.c.campaign == campaign).order_by(CAMPAIGN_JOBS.c.n.desc())
    if kind is not None:
        query = query.where(CAMPAIGN_JOBS.c.kind == kind)
    with reading(service.engine) as connection:
        names = connection.scalars(query).all()
    return [service.jobs.get(name) for name in names]


def _runs(service: Service, campaign: str, requested: tuple[str, ...] | None) -> tuple[str, ...]:
    known = service.repository.campaign(campaign).runs
    foreign = [run for run in requested or () if run not in known]
    if foreign:
        raise NotFoundError(f"campaign {campaign} has no run {foreign[0]!r}", where="runs", remedy="look at its runs")
    records = [service.store.catalogue.run(run) for run in requested or known]
    going_on = [record.id for record in records if record.state not in ENDED]
    if requested and going_on:
        raise ConflictError(f"run {going_on[0]} is going on", where="runs", remedy="wait for its end")
    ended = (record.id for record in records if record.state in ENDED and record.valid)
    usable = tuple(run for run in ended if _counts(service, run))
    if not usable:
        raise ConflictError("there is no ended, valid run with good blocks", where=campaign, remedy="record one first")
    return usable


def _counts(service: Service, run: str) -> bool:
    return any(block.note.accepted for block in service.store.catalogue.blocks(run))
