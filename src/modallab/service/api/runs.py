"""Runs: begin, look at, command."""

from fastapi import Response

from modallab.core.documents.pages import Page
from modallab.core.documents.runs import RunView
from modallab.service.api.bodies import NewRun, RunCommand
from modallab.service.api.cursor import Cursor, Limit, page, place_of
from modallab.service.api.etag import IfNoneMatch, mark, unchanged
from modallab.service.api.problems import documented
from modallab.service.api.request_context import LeaseId, ServiceOf
from modallab.service.api.router import ONCE, PREFIX, make_router
from modallab.service.campaigns.begin import begin
from modallab.service.campaigns.runs import run_view
from modallab.service.errors import ConflictError

router = make_router("runs")


@router.get("/campaigns/{campaign}/runs", responses=documented(404))
def list_runs(campaign: str, service: ServiceOf, limit: Limit = 50, cursor: Cursor = None) -> Page[RunView]:
    """The runs of a campaign, the oldest first."""
    after = place_of(cursor)
    names = [run for run in service.repository.campaign(campaign).runs if after is None or run > after]
    return page([run_view(service, run) for run in names[: limit + 1]], limit, lambda run: run.id)


@router.post("/campaigns/{campaign}/runs", status_code=202, dependencies=ONCE, responses=documented(404, 409, 507))
def start_run(campaign: str, new: NewRun, service: ServiceOf, response: Response, lease: LeaseId = None) -> RunView:
    """Begin a run on the campaign's rig; needs the rig's lease. Follow it by its events or at `Location`."""
    run = begin(service, campaign, new, lease)
    response.headers["Location"] = f"{PREFIX}/runs/{run}"
    return run_view(service, run)


@router.get("/runs/{run}", response_model=RunView, responses={304: {"description": "unchanged"}} | documented(404))
def get_run(run: str, service: ServiceOf, response: Response, if_none_match: IfNoneMatch = None) -> RunView | Response:
    """A run as it stands."""
    view = run_view(service, run)
    tag = f"{view.state}-{view.blocks}-{view.accepted}-{view.code}"
    if unchanged(if_none_match, tag):
        return Response(status_code=304, headers={"ETag": f'"{tag}"'})
    mark(response, tag)
    return view


@router.post("/runs/{run}/commands", status_code=202, dependencies=ONCE, responses=documented(404, 409, 507))
def command_run(run: str, command: RunCommand, service: ServiceOf, lease: LeaseId = None) -> RunView:
    """Pause, resume, repeat a frequency, drop a hit, stop or abort; needs the rig's lease."""
    view = run_view(service, run)
    if view.rig is None:
        raise ConflictError(f"run {run} was not begun by this service", where=run, remedy="use its own program")
    service.control.command(view.rig, run, command, lease)
    return run_view(service, run)
