"""Events: followed as they come (SSE), or read page by page."""

from collections.abc import AsyncGenerator
from typing import Annotated

from fastapi import Header, Query, Request
from fastapi.responses import StreamingResponse

from modallab.core.documents.pages import AuditEntry, EventView, Page
from modallab.core.errors import DataError
from modallab.service.api.cursor import Cursor, Limit, number_of, page
from modallab.service.api.event_feed import Feed
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import make_router
from modallab.service.records import audit
from modallab.service.records.event_log import Topic

router = make_router("events")
Name = Annotated[str, Query(max_length=64)]
After = Annotated[int | None, Query(ge=0, lt=2**53, description="Begin after this event; 0: with the first one.")]
LastEventId = Annotated[str | None, Header(alias="Last-Event-ID", max_length=20)]
STREAM = "text/event-stream"


@router.get(
    "/events/stream",
    response_class=StreamingResponse,
    responses={200: {"content": {STREAM: {}}}},
)
async def follow_events(
    request: Request,
    after: After = None,
    last: LastEventId = None,
    rig: Name = "",
    campaign: Name = "",
    run: Name = "",
    to_end: Annotated[bool, Query(description="Close when a run has ended.")] = False,
) -> StreamingResponse:
    """Follow events as server-sent events, from now on or, by `Last-Event-ID`, from where you were."""
    if last is not None and not (last.isascii() and last.isdigit()):
        raise DataError(f"{last!r} is no event's number", where="Last-Event-ID", remedy="send the id of the last one")
    feed: Feed = request.app.state.feed
    lines: AsyncGenerator[bytes] = feed.listen(
        int(last) if last is not None else after, Topic(rig, campaign, run), to_end=to_end
    )
    return StreamingResponse(lines, media_type=STREAM, headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})


@router.get("/events")
def list_events(
    service: ServiceOf, limit: Limit = 100, cursor: Cursor = None, rig: Name = "", campaign: Name = "", run: Name = ""
) -> Page[EventView]:
    """Events page by page, the oldest first."""
    found = service.log.after(number_of(cursor) or 0, limit + 1, Topic(rig, campaign, run))
    return page(found, limit, lambda event: event.seq)


@router.get("/audit")
def list_audit(service: ServiceOf, limit: Limit = 100, cursor: Cursor = None) -> Page[AuditEntry]:
    """Who did what, the newest first."""
    found = audit.entries(service.engine, number_of(cursor), limit + 1)
    return page(found, limit, lambda entry: entry.seq)
