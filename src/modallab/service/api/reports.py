"""Reports of a campaign, as pages."""

from fastapi import Response
from fastapi.responses import HTMLResponse

from modallab.service.api.problems import documented
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import make_router
from modallab.service.jobs.result_files import job_file, newest_file

router = make_router("jobs")
# A report is made of names that people typed: whatever they are, it reaches nothing of the service.
_ALONE = {
    "Content-Security-Policy": "sandbox allow-scripts; default-src 'none'; style-src 'unsafe-inline';"
    " script-src 'unsafe-inline'; img-src data:; font-src data:"
}


@router.get("/campaigns/{campaign}/report", response_class=HTMLResponse, responses=documented(404))
def get_report(campaign: str, service: ServiceOf) -> Response:
    """The newest report of a campaign; order one at `/campaigns/{campaign}/reports`."""
    return HTMLResponse(newest_file(service, campaign, "report", "report.html"), headers=_ALONE)


@router.get("/campaigns/{campaign}/diagnosis", response_class=HTMLResponse, responses=documented(404))
def get_diagnosis(campaign: str, service: ServiceOf) -> Response:
    """The newest diagnosis of a campaign as a page; order one at `/campaigns/{campaign}/diagnoses`."""
    return HTMLResponse(newest_file(service, campaign, "diagnose", "gap.html"), headers=_ALONE)


@router.get("/jobs/{job}/files/{name}", response_class=HTMLResponse, responses=documented(404))
def get_job_file(job: str, name: str, service: ServiceOf) -> Response:
    """A page that a job left, by the names in its result."""
    return HTMLResponse(job_file(service, service.jobs.get(job), name), headers=_ALONE)
