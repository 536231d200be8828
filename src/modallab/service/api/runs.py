"""Runs: begin, look at, command, and the FRF as far as a run has come."""

from typing import Annotated

from fastapi import Body, Query, Response
from fastapi.openapi.models import Example

from modallab.core.documents.pages import Page
from modallab.core.documents.results import FrfView
from modallab.core.documents.runs import Command, RunRequest, RunView
from modallab.core.frf import UNIT
from modallab.core.units import FrfEstimator
from modallab.service.api.campaigns import Archived, Deleted
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import (
    Cursor,
    IfNoneMatch,
    LeaseId,
    Limit,
    ServiceOf,
    is_unchanged,
    page_cursor,
    page_of_items,
    set_etag,
)
from modallab.service.api.router import ONCE, PREFIX, Key, make_router
from modallab.service.campaigns.run_start import begin_run
from modallab.service.campaigns.runs import block_records, run_view
from modallab.service.errors import ConflictError

router = make_router("runs")
NewRun = Annotated[
    RunRequest,
    Body(
        openapi_examples={
            "impact test": Example(value={"plan": {"kind": "impact", "points": [10, 6, 3], "hits": 5}}),
            "sine test": Example(value={"plan": {"kind": "sine", "frequencies_hz": [20.0, 40.0]}}),
        }
    ),
]
RunCommand = Annotated[
    Command,
    Body(
        openapi_examples={
            "pause": Example(value={"kind": "pause"}),
            "repeat one frequency": Example(value={"kind": "repeat", "frequency_hz": 20.0}),
            "drop one hit": Example(value={"kind": "drop", "n": 3, "reason": "hit beside the point"}),
        }
    ),
]


@router.get("/campaigns/{campaign}/runs", responses=documented_responses(404))
def list_runs(
    campaign: str,
    service: ServiceOf,
    limit: Limit = 50,
    cursor: Cursor = None,
    archived: Archived = False,
    deleted: Deleted = False,
) -> Page[RunView]:
    """The runs of a campaign, the oldest first; archived or deleted ones only on request."""
    after = page_cursor(cursor)
    # The one a page ended with may have been set aside since.
    names = service.repository.runs(campaign, archived=True, deleted=True)
    if after is not None:
        names = names[names.index(after) + 1 :] if after in names else ()
    shown = set(service.repository.runs(campaign, archived=archived, deleted=deleted))
    names = [run for run in names if run in shown]
    return page_of_items([run_view(service, run) for run in names[: limit + 1]], limit, lambda run: run.id)


@router.post("/campaigns/{campaign}/runs", status_code=202, responses=documented_responses(404, 409, 507))
def start_run(
    campaign: str, new: NewRun, service: ServiceOf, response: Response, key: Key, lease: LeaseId = None
) -> RunView:
    """Start a run on the campaign's rig; needs the rig's lease. Follow it by its events or at `Location`."""
    run = begin_run(service, campaign, new, lease, key)
    response.headers["Location"] = f"{PREFIX}/runs/{run}"
    return run_view(service, run)


@router.get(
    "/runs/{run}", response_model=RunView, responses={304: {"description": "unchanged"}} | documented_responses(404)
)
def get_run(run: str, service: ServiceOf, response: Response, if_none_match: IfNoneMatch = None) -> RunView | Response:
    """A run in its present state."""
    view = run_view(service, run)
    tag = f"{view.state}-{view.blocks}-{view.accepted}-{view.code}-{view.archived_utc}{view.deleted_utc}"
    if is_unchanged(if_none_match, tag):
        return Response(status_code=304, headers={"ETag": f'"{tag}"'})
    set_etag(response, tag)
    return view


@router.post("/runs/{run}/commands", status_code=202, dependencies=ONCE, responses=documented_responses(404, 409, 507))
def command_run(run: str, command: RunCommand, service: ServiceOf, lease: LeaseId = None) -> RunView:
    """Pause, resume, repeat a frequency, drop a hit, stop or abort; needs the rig's lease."""
    view = run_view(service, run)
    if view.rig is None:
        raise ConflictError(f"another program started run {run}", where=run, remedy="use the program that started it")
    service.control.command(view.rig, run, command, lease)
    return run_view(service, run)


frf_router = make_router("frf")


@frf_router.get(
    "/runs/{run}/frf",
    response_model=FrfView,
    responses={304: {"description": "unchanged"}} | documented_responses(404, 409),
)
def get_frf(
    run: str,
    service: ServiceOf,
    response: Response,
    if_none_match: IfNoneMatch = None,
    estimator: Annotated[FrfEstimator, Query(description="H2 and Hv allow for noise on the force.")] = "H1",
) -> FrfView | Response:
    """Mobility and coherence of the valid blocks; the ETag changes with every block."""
    counted = [row.n for row in block_records(service, run) if row.note.accepted]
    tag = f"{estimator}-{len(counted)}-{hash(tuple(counted)) & 0xFFFFFFFF:08x}"
    if is_unchanged(if_none_match, tag):
        return Response(status_code=304, headers={"ETag": f'"{tag}"'})
    frf = service.frfs().frf(run, estimator=estimator)
    set_etag(response, tag)
    return FrfView.of_fields(frf, run=run, unit=UNIT[frf.quantity])
