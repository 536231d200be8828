"""Events: followed as they come (SSE), or read page by page."""

import asyncio
import logging
import time
from collections.abc import AsyncGenerator
from concurrent.futures import wait
from contextlib import suppress
from dataclasses import dataclass, field
from threading import Event as Flag
from threading import Thread
from typing import Annotated

from fastapi import Header, Query, Request
from fastapi.responses import StreamingResponse

from modallab.core.documents.pages import AuditEntry, EventView, Page
from modallab.core.errors import DataError, ModallabError
from modallab.service.api.request_context import Cursor, Limit, ServiceOf, page_cursor_number, page_of_items
from modallab.service.api.router import make_router
from modallab.service.records import audit
from modallab.service.records.event_log import EventLog, EventTopic
from modallab.storage.recorder import utc_now
from modallab.storage.records import ENDED

LOG = logging.getLogger(__name__)
STILL_HERE = b": still here\n\n"
LOOK_S = 0.2
"""Between two looks at the log where nobody says that there is something new in it."""
HAND_OUT_S = 0.05
AT_ONCE = 500
TOGETHER = 20
PAUSE_S = 0.002
"""Between so many listeners and the next: those write their lines, and others get their turn."""
UNREAD_S = 2.0
"""The log is looked at all the time; unread for so long, its database does not answer."""
QUEUE = 2000
"""Events a listener may be behind; a slower one is let go and reads on by Last-Event-ID."""


@dataclass(frozen=True, slots=True)
class EventLine:
    """An event and how it goes over the wire, written once for all."""

    event: EventView
    text: bytes


@dataclass(eq=False, slots=True)
class EventListener:
    """One who listens; `None` in the queue ends it."""

    queue: asyncio.Queue[EventLine | None] = field(default_factory=lambda: asyncio.Queue(QUEUE))


class EventFeed:
    """A thread looks at the log; listeners wait in the event loop."""

    def __init__(self, log: EventLog) -> None:
        self._log = log
        self._listeners: set[EventListener] = set()
        self._closing = Flag()
        self._new = Flag()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._read = (time.monotonic(), utc_now())
        self._last: int | None = None
        self._thread = Thread(target=self._look, name="events", daemon=True)

    @property
    def listeners(self) -> int:
        """How many listen."""
        return len(self._listeners)

    @property
    def unread_since(self) -> str:
        """Since when, in UTC, the log cannot be read; "" if it can."""
        read_s, utc = self._read
        return utc if time.monotonic() - read_s > UNREAD_S else ""

    def open(self) -> None:
        """Begin; from the event loop."""
        self._loop = asyncio.get_running_loop()
        # Before anyone can listen: what comes between their first look and the thread's is handed out too.
        with suppress(ModallabError):
            self._last = self._log.newest_number()
        self._thread.start()

    def close(self) -> None:
        """Let everyone go; from the event loop."""
        self._closing.set()
        self._new.set()
        for listener in self._listeners:
            _put_line(listener, None)

    async def listen(self, after: int | None, topic: EventTopic, *, to_end: bool = False) -> AsyncGenerator[bytes]:
        """Events as SSE text, from the one after number `after`, or from now on; a comment now and then.

        With `to_end` no more after the first event that says that a run has ended.
        """
        listener = EventListener()
        self._listeners.add(listener)
        try:
            newest = await asyncio.to_thread(self._log.newest_number)
            # A number that is not there yet is of another database: nobody can wait for it.
            last = newest if after is None else min(after, newest)
            yield b": listening\n\n"
            if after is not None:
                while before := await asyncio.to_thread(self._log.events_after, last, AT_ONCE, topic):
                    yield b"".join(_event_text(event) for event in before)
                    last = before[-1].seq
                    if to_end and any(_ends_stream(event) for event in before):
                        return
            if to_end and await asyncio.to_thread(self._log.has_ended, topic.run, last):
                return
            async for line in _follow_log(listener, last, topic):
                yield line.text if line is not None else STILL_HERE
                if to_end and line is not None and _ends_stream(line.event):
                    return
        finally:
            self._listeners.discard(listener)

    async def follow(self, topic: EventTopic) -> AsyncGenerator[EventView | None]:
        """Events from now on; None first, once nothing that comes after is missed, and now and then."""
        listener = EventListener()
        self._listeners.add(listener)
        try:
            yield None
            async for line in _follow_log(listener, -1, topic):
                yield None if line is None else line.event
        finally:
            self._listeners.discard(listener)

    def check_now(self) -> None:
        """There is something new in the log: look now. From any thread."""
        self._new.set()

    def _look(self) -> None:
        last, lost = self._last, False
        while not self._closing.is_set():
            self._new.wait(LOOK_S)
            self._new.clear()
            try:
                last = self._log.newest_number() if last is None else last
                events = self._log.events_after(last, AT_ONCE)
            except ModallabError as error:
                if not lost:
                    LOG.warning("events cannot be read: %s", error)
                lost = True
                continue
            lost, self._read = False, (time.monotonic(), utc_now())
            if events and self._loop is not None:
                last = events[-1].seq
                self._hand_to(self._loop, [EventLine(event, _event_text(event)) for event in events])

    def _hand_to(self, loop: asyncio.AbstractEventLoop, lines: list[EventLine]) -> None:
        handing_out = self._hand_out(lines)
        try:
            handed_out = asyncio.run_coroutine_threadsafe(handing_out, loop)
        except RuntimeError:
            handing_out.close()
            if not loop.is_closed():
                raise
            # The service has been closed between the look and here, and with it everyone who listened.
            return
        # One after the other: the order of events is that of the log.
        while not self._closing.is_set() and not handed_out.done():
            wait([handed_out], HAND_OUT_S)

    async def _hand_out(self, lines: list[EventLine]) -> None:
        # Not all at once: a thousand listeners that wake together keep live samples and answers waiting.
        for n, listener in enumerate(list(self._listeners)):
            if n % TOGETHER == TOGETHER - 1:
                await asyncio.sleep(PAUSE_S)
            for line in lines:
                _put_line(listener, line)


def _ends_stream(event: EventView) -> bool:
    return event.kind == "state" and event.content["state"] in ENDED


async def _follow_log(listener: EventListener, last: int, topic: EventTopic) -> AsyncGenerator[EventLine | None]:
    while True:
        try:
            line = await asyncio.wait_for(listener.queue.get(), 15.0)
        except TimeoutError:
            yield None
            continue
        if line is None:
            return
        if line.event.seq > last and _is_of(line.event, topic):
            yield line


def _put_line(listener: EventListener, line: EventLine | None) -> None:
    if listener.queue.full():
        listener.queue.get_nowait()
        line = None
    listener.queue.put_nowait(line)


def _is_of(event: EventView, topic: EventTopic) -> bool:
    return all(not requested or requested == found for requested, found in (
        (topic.rig, event.rig), (topic.campaign, event.campaign), (topic.run, event.run),
    ))  # fmt: skip


def _event_text(event: EventView) -> bytes:
    return f"id: {event.seq}\nevent: {event.kind}\ndata: {event.model_dump_json()}\n\n".encode()


router = make_router("events")
Name = Annotated[str, Query(max_length=64)]
After = Annotated[
    int | None, Query(ge=0, lt=2**53, description="Begin after this event; 0 begins with the first event.")
]
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
    to_end: Annotated[bool, Query(description="Close the stream when a run has ended.")] = False,
) -> StreamingResponse:
    """Follow events as server-sent events, from now on or from `Last-Event-ID`."""
    if last is not None and not (last.isascii() and last.isdigit()):
        raise DataError(f"{last!r} is no event's number", where="Last-Event-ID", remedy="send the id of the last event")
    feed: EventFeed = request.app.state.feed
    lines: AsyncGenerator[bytes] = feed.listen(
        int(last) if last is not None else after, EventTopic(rig, campaign, run), to_end=to_end
    )
    return StreamingResponse(lines, media_type=STREAM, headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"})


@router.get("/events")
def list_events(
    service: ServiceOf, limit: Limit = 100, cursor: Cursor = None, rig: Name = "", campaign: Name = "", run: Name = ""
) -> Page[EventView]:
    """Events page by page, the oldest first."""
    found = service.log.events_after(page_cursor_number(cursor) or 0, limit + 1, EventTopic(rig, campaign, run))
    return page_of_items(found, limit, lambda event: event.seq)


@router.get("/audit")
def list_audit(service: ServiceOf, limit: Limit = 100, cursor: Cursor = None) -> Page[AuditEntry]:
    """The audit record: user, action and object, the newest first."""
    found = audit.audit_entries(service.engine, page_cursor_number(cursor), limit + 1)
    return page_of_items(found, limit, lambda entry: entry.seq)
