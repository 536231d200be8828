"""Jobs: identification, diagnosis and reports, ordered and followed."""

from fastapi import Response

from modallab.core.documents.pages import Page
from modallab.core.documents.results import JobKind, JobNew, JobState, JobView
from modallab.jobs import Job
from modallab.service.api.bodies import NewJob
from modallab.service.api.cursor import Cursor, Limit
from modallab.service.api.problems import documented
from modallab.service.api.request_context import Operator, ServiceOf
from modallab.service.api.router import ONCE, PREFIX, make_router
from modallab.service.context import Service
from modallab.service.jobs.orders import campaign_jobs, order

router = make_router("jobs")
_ORDER = documented(404, 409, 507)


@router.get("/jobs")
def list_jobs(
    service: ServiceOf,
    limit: Limit = 50,
    cursor: Cursor = None,
    state: JobState | None = None,
    kind: JobKind | None = None,
) -> Page[JobView]:
    """All jobs, the newest first."""
    found = service.jobs.list(state=state, kind=kind, cursor=cursor, limit=limit)
    return Page(items=tuple(_view(job) for job in found.jobs), next=found.cursor)


@router.get("/jobs/{job}", responses=documented(404))
def get_job(job: str, service: ServiceOf) -> JobView:
    """A job as it stands, with its result once it is done."""
    return _view(service.jobs.get(job))


@router.delete("/jobs/{job}", responses=documented(404, 507))
def cancel_job(job: str, service: ServiceOf, operator: Operator) -> JobView:
    """Cancel a job; one that has ended stays as it is."""
    return _view(service.cancel(job, operator))


@router.post("/campaigns/{campaign}/models", status_code=202, dependencies=ONCE, responses=_ORDER)
def identify(campaign: str, service: ServiceOf, operator: Operator, response: Response, new: NewJob = None) -> JobView:
    """Order the modal model of a campaign's runs. After a run this is done by itself."""
    return _ordered(service, campaign, "identify", new, operator, response)


@router.post("/campaigns/{campaign}/diagnoses", status_code=202, dependencies=ONCE, responses=_ORDER)
def diagnose(campaign: str, service: ServiceOf, operator: Operator, response: Response, new: NewJob = None) -> JobView:
    """Order the diagnosis of where simulation and bench differ, and why."""
    return _ordered(service, campaign, "diagnose", new, operator, response)


@router.post("/campaigns/{campaign}/reports", status_code=202, dependencies=ONCE, responses=_ORDER)
def report(campaign: str, service: ServiceOf, operator: Operator, response: Response, new: NewJob = None) -> JobView:
    """Order the report of a campaign."""
    return _ordered(service, campaign, "report", new, operator, response)


@router.get("/campaigns/{campaign}/jobs", responses=documented(404))
def list_campaign_jobs(campaign: str, service: ServiceOf, kind: JobKind | None = None) -> Page[JobView]:
    """The jobs of a campaign, the newest first."""
    return Page(items=tuple(_view(job) for job in campaign_jobs(service, campaign, kind)))


def _ordered(
    service: Service, campaign: str, kind: JobKind, new: JobNew | None, operator: str, response: Response
) -> JobView:
    job = order(service, campaign, kind, new or JobNew(), operator)
    response.headers["Location"] = f"{PREFIX}/jobs/{job.id}"
    return _view(job)


def _view(job: Job) -> JobView:
    return JobView.model_validate(job.model_dump())
