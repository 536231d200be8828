"""Campaigns: make, list, read, rename, export."""

from typing import Annotated

from fastapi import Body, Query, Response
from fastapi.openapi.models import Example
from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from modallab.core.documents.pages import Page
from modallab.core.documents.runs import CampaignChange, CampaignRequest, CampaignView
from modallab.service.api.access import require_rig
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import (
    NOTES,
    CallerOf,
    Cursor,
    IfMatch,
    IfNoneMatch,
    Limit,
    Operator,
    ServiceOf,
    is_unchanged,
    page_cursor,
    page_of_items,
    revision_of,
    set_etag,
)
from modallab.service.api.rigs import process_state
from modallab.service.api.router import ONCE, PREFIX, make_router
from modallab.service.campaigns.export import ExportedFile, export_campaign

router = make_router("campaigns")
ChangedCampaign = Annotated[
    CampaignChange, Body(openapi_examples={"rename": Example(value={"name": "second session"})})
]
NewCampaign = Annotated[
    CampaignRequest,
    Body(openapi_examples={"session": Example(value={"name": "first session", "rig": "link", "note": "new clamp"})}),
]

Archived = Annotated[bool, Query(description="Whether to list archived ones too.")]
Deleted = Annotated[bool, Query(description="Whether to list deleted ones too.")]
Search = Annotated[str, Query(max_length=120, pattern=r"^[^\x00-\x1f\x7f]*$")]
FILE = "application/octet-stream"
BINARY = {"type": "string", "format": "binary"}


@router.get("/campaigns")
def list_campaigns(
    service: ServiceOf,
    limit: Limit = 50,
    cursor: Cursor = None,
    rig: Search = "",
    text: Search = "",
    archived: Archived = False,
    deleted: Deleted = False,
) -> Page[CampaignView]:
    """Campaigns, the newest first: all, or those of a rig, or with a text in their name or note.

    Those that are archived or deleted are listed only where they are asked for.
    """
    found = service.repository.campaigns(
        page_cursor(cursor), limit + 1, rig=rig, text=text, archived=archived, deleted=deleted
    )
    return page_of_items(found, limit, lambda campaign: campaign.id)


@router.post("/campaigns", status_code=201, dependencies=ONCE, responses=documented_responses(404, 409, 507))
def create_campaign(
    new: NewCampaign, service: ServiceOf, operator: Operator, caller: CallerOf, response: Response
) -> CampaignView:
    """Make a campaign on a rig."""
    require_rig(caller, new.rig)
    process_state(service, new.rig)
    campaign = service.repository.create(new, operator)
    response.headers["Location"] = f"{PREFIX}/campaigns/{campaign.id}"
    set_etag(response, campaign.revision)
    return campaign


@router.get(
    "/campaigns/{campaign}",
    response_model=CampaignView,
    responses={304: {"description": "unchanged"}} | documented_responses(404),
)
def get_campaign(
    campaign: str, service: ServiceOf, response: Response, if_none_match: IfNoneMatch = None
) -> CampaignView | Response:
    """A campaign and the names of its runs."""
    found = service.repository.campaign(campaign)
    if is_unchanged(if_none_match, found.revision):
        return Response(status_code=304, headers={"ETag": f'"{found.revision}"'})
    set_etag(response, found.revision)
    return found


@router.patch("/campaigns/{campaign}", responses=documented_responses(404, 412, 428, 507))
def change_campaign(
    campaign: str,
    change: ChangedCampaign,
    service: ServiceOf,
    operator: Operator,
    response: Response,
    if_match: IfMatch = None,
) -> CampaignView:
    """Rename a campaign or change its note; `If-Match` gives the revision that you read."""
    changed = service.repository.change(campaign, change, revision_of(if_match), operator)
    set_etag(response, changed.revision)
    return changed


@router.get(
    "/campaigns/{campaign}/export",
    response_class=Response,
    responses={200: {"content": {FILE: {"schema": BINARY}}}} | documented_responses(404, 409, 507),
)
def export(
    campaign: str,
    service: ServiceOf,
    to: Annotated[str, Query(max_length=16, description="Name of a format: hdf5, uff, csv, tdms, ...")] = "hdf5",
) -> FileResponse:
    """The valid runs of a campaign as one file, a zip where the format is a folder.

    `Modallab-Notes` says what had no place in the format.
    """
    return file_response(export_campaign(service, campaign, to))


def file_response(exported: ExportedFile) -> FileResponse:
    """The file, removed once it is sent; a header says what had no place in it."""
    headers = {NOTES: "; ".join(exported.notes)} if exported.notes else None
    removed = BackgroundTask(exported.remove)
    return FileResponse(
        exported.path, media_type=FILE, filename=exported.path.name, headers=headers, background=removed
    )
