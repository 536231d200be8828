"""Jobs: identification, diagnosis and reports, ordered, followed, and read as pages."""

from typing import Annotated

from fastapi import Body, Response
from fastapi.openapi.models import Example
from fastapi.responses import HTMLResponse

from modallab.core.documents.pages import Page
from modallab.core.documents.results import JobKind, JobRequest, JobState, JobView
from modallab.jobs import Job
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import Cursor, Limit, Operator, ServiceOf
from modallab.service.api.router import ONCE, PREFIX, make_router
from modallab.service.context import Service
from modallab.service.jobs.campaign_jobs import (
    campaign_jobs,
    job_file,
    newest_file,
    order_blind,
    order_estimate,
    order_job,
)

router = make_router("jobs")
NewJob = Annotated[
    JobRequest | None,
    Body(
        openapi_examples={"with its settings": Example(value={"parameters": {"title": "Report of the first session"}})}
    ),
]
_ORDER = documented_responses(404, 409, 507)


@router.get("/jobs")
def list_jobs(
    service: ServiceOf,
    limit: Limit = 50,
    cursor: Cursor = None,
    state: JobState | None = None,
    kind: JobKind | None = None,
) -> Page[JobView]:
    """All jobs, the newest first; without their results, which `/jobs/{job}` gives."""
    found = service.jobs.list(state=state, kind=kind, cursor=cursor, limit=limit)
    return Page(items=tuple(job_in_list(job) for job in found.jobs), next=found.cursor)


@router.get("/jobs/{job}", responses=documented_responses(404))
def get_job(job: str, service: ServiceOf) -> JobView:
    """A job in its present state, with its result once it is done."""
    return _job_view(service.jobs.get(job))


@router.delete("/jobs/{job}", responses=documented_responses(404, 507))
def cancel_job(job: str, service: ServiceOf, operator: Operator) -> JobView:
    """Cancel a job; an ended job does not change."""
    return _job_view(service.cancel(job, operator))


@router.post("/campaigns/{campaign}/models", status_code=202, dependencies=ONCE, responses=_ORDER)
def identify(campaign: str, service: ServiceOf, operator: Operator, response: Response, new: NewJob = None) -> JobView:
    """Order the modal model of a campaign's runs. After a run this is done automatically."""
    return _order_job(service, campaign, "identify", new, operator, response)


@router.post("/campaigns/{campaign}/diagnoses", status_code=202, dependencies=ONCE, responses=_ORDER)
def diagnose(campaign: str, service: ServiceOf, operator: Operator, response: Response, new: NewJob = None) -> JobView:
    """Order the diagnosis of where simulation and bench differ, and why."""
    return _order_job(service, campaign, "diagnose", new, operator, response)


@router.post("/campaigns/{campaign}/reports", status_code=202, dependencies=ONCE, responses=_ORDER)
def report(campaign: str, service: ServiceOf, operator: Operator, response: Response, new: NewJob = None) -> JobView:
    """Order the report of a campaign."""
    return _order_job(service, campaign, "report", new, operator, response)


@router.post("/blind-trials", status_code=202, dependencies=ONCE, responses=_ORDER)
def blind_trials(service: ServiceOf, operator: Operator, response: Response, new: NewJob = None) -> JobView:
    """Order blind trials of the diagnosis on simulated benches. They belong to no campaign: leave out `runs`."""
    job = order_blind(service, new or JobRequest(), operator)
    response.headers["Location"] = f"{PREFIX}/jobs/{job.id}"
    return _job_view(job)


@router.get("/campaigns/{campaign}/jobs", responses=documented_responses(404))
def list_campaign_jobs(campaign: str, service: ServiceOf, kind: JobKind | None = None) -> Page[JobView]:
    """The jobs of a campaign, the newest first; without their results."""
    return Page(items=tuple(job_in_list(job) for job in campaign_jobs(service, campaign, kind)))


@router.post("/runs/{run}/estimates", status_code=202, dependencies=ONCE, responses=_ORDER)
def estimate(run: str, service: ServiceOf, operator: Operator, response: Response) -> JobView:
    """Order the modes of a run so far, each with its standard deviation; also during the run."""
    job = order_estimate(service, run, operator)
    response.headers["Location"] = f"{PREFIX}/jobs/{job.id}"
    return _job_view(job)


def _order_job(
    service: Service, campaign: str, kind: JobKind, new: JobRequest | None, operator: str, response: Response
) -> JobView:
    job = order_job(service, campaign, kind, new or JobRequest(), operator)
    response.headers["Location"] = f"{PREFIX}/jobs/{job.id}"
    return _job_view(job)


def job_in_list(job: Job) -> JobView:
    """A job as it stands in a list: without its result, which may be large."""
    return _job_view(job.model_copy(update={"result": None}))


def _job_view(job: Job) -> JobView:
    return JobView.model_validate(job.model_dump(exclude={"revision"}))


# A report is made of names that people typed: whatever they are, it reaches nothing of the service.
_ALONE = {
    "Content-Security-Policy": "sandbox allow-scripts; default-src 'none'; style-src 'unsafe-inline';"
    " script-src 'unsafe-inline'; img-src data:; font-src data:"
}


@router.get("/campaigns/{campaign}/report", response_class=HTMLResponse, responses=documented_responses(404))
def get_report(campaign: str, service: ServiceOf) -> Response:
    """The newest report of a campaign; order one at `/campaigns/{campaign}/reports`."""
    return HTMLResponse(newest_file(service, campaign, "report", "report.html"), headers=_ALONE)


@router.get("/campaigns/{campaign}/diagnosis", response_class=HTMLResponse, responses=documented_responses(404))
def get_diagnosis(campaign: str, service: ServiceOf) -> Response:
    """The newest diagnosis of a campaign as a page; order one at `/campaigns/{campaign}/diagnoses`."""
    return HTMLResponse(newest_file(service, campaign, "diagnose", "gap.html"), headers=_ALONE)


@router.get("/jobs/{job}/files/{name}", response_class=HTMLResponse, responses=documented_responses(404))
def get_job_file(job: str, name: str, service: ServiceOf) -> Response:
    """A file that a job wrote, by its name in the result."""
    return HTMLResponse(job_file(service, service.jobs.get(job), name), headers=_ALONE)
