"""Live by WebSocket: samples without holes, their envelope, and FRFs that grow with every block."""

import asyncio
import contextlib
import logging
from collections.abc import AsyncGenerator, Awaitable, Callable
from dataclasses import replace
from typing import Annotated, TypeVar

from fastapi import APIRouter, Query, WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from modallab.acquisition.process.idle_view import idle_ring_buffer_name
from modallab.core.documents.rigs import StopRequest
from modallab.core.documents.users import CallerView
from modallab.core.errors import ModallabError
from modallab.service.api.events import EventFeed
from modallab.service.api.request_context import CALLER
from modallab.service.api.router import PREFIX
from modallab.service.campaigns.live_frf import FrfSelection, FrfWatch
from modallab.service.campaigns.live_samples import LiveView, ViewSelection
from modallab.service.context import Service
from modallab.service.records.event_log import EventTopic

router = APIRouter(prefix=PREFIX)
LOOK_S = 0.03
WRONG = 4422
"""Close code of a request that cannot be answered; the reason says why."""
REASON = 100
"""Bytes a reason may have."""
CHANGES = frozenset({"block", "dropped", "verdict"})
LOG = logging.getLogger(__name__)
Stop = Callable[[StopRequest], Awaitable[None]]
Rig = Annotated[str, Query(max_length=64, description="Only this rig.")]
Run = Annotated[str, Query(max_length=64, description="Only this run.")]
Idle = Annotated[bool, Query(description="Whether to send samples also between runs; `run` is empty then.")]
T = TypeVar("T")
Channels = Annotated[list[str], Query(max_length=256, description="Send only these channels; repeat for several.")]
Outputs = Annotated[list[str], Query(max_length=256, description="Send only these outputs; repeat for several.")]


@router.websocket("/live")
async def show_samples(
    socket: WebSocket,
    rig: Rig = "",
    run: Run = "",
    channel: Channels = [],  # noqa: B006, FastAPI's way
    after: Annotated[int | None, Query(ge=0, lt=2**62, description="Begin with the sample at this `position`.")] = None,
    idle: Idle = False,
) -> None:
    """Samples of active runs, from now, or from sample `after` as far as it is still available."""
    await _show_samples(socket, ViewSelection(rig, run, tuple(channel), after), idle)


@router.websocket("/live/envelope")
async def show_envelope(
    socket: WebSocket,
    rig: Rig = "",
    run: Run = "",
    channel: Channels = [],  # noqa: B006, FastAPI's way
    columns_per_s: Annotated[float, Query(gt=0, le=2000, description="Columns a second.")] = 50.0,
    idle: Idle = False,
) -> None:
    """Minimum and maximum of each interval, for a picture of a fixed width."""
    await _show_samples(socket, ViewSelection(rig, run, tuple(channel), None, columns_per_s), idle)


@router.websocket("/runs/{run}/frf/live")
async def show_frf(
    socket: WebSocket,
    run: str,
    output: Outputs = [],  # noqa: B006, FastAPI's way
    low_hz: Annotated[float, Query(ge=0, description="Lowest line, in Hz.")] = 0.0,
    high_hz: Annotated[float, Query(gt=0, description="Highest line, in Hz.")] = 1e9,
) -> None:
    """Mobility and coherence of each point: all at first, then each time a block is added or removed."""
    service: Service = socket.app.state.service
    feed: EventFeed = socket.app.state.feed
    watch = FrfWatch(service, FrfSelection(run, tuple(output), low_hz, high_hz))
    await socket.accept()
    async with _while_there(socket) as gone:
        try:
            async for event in _until_gone_or_found(feed.follow(EventTopic(run=run)), gone):
                if event is None or event.kind in CHANGES:
                    for found in await asyncio.to_thread(watch.check_now):
                        await socket.send_bytes(found)
        except ModallabError as error:
            await socket.close(WRONG, error.what[:REASON])


async def _show_samples(socket: WebSocket, chosen: ViewSelection, idle: bool) -> None:
    service: Service = socket.app.state.service
    rigs: dict[str, str] = {}
    if idle:
        states = await asyncio.to_thread(service.control.states)
        rigs = {idle_ring_buffer_name(state.bench): state.id for state in states if chosen.rig in ("", state.id)}
        chosen = replace(chosen, idle=tuple(rigs))

    def rig_of(run: str) -> str:
        entry = None if run in rigs else service.repository.run_entry(run)
        return rigs.get(run, "") if entry is None else entry.rig

    view = LiveView(service.folder, rig_of, chosen)

    async def stop(asked: StopRequest) -> None:
        caller: CallerView = socket.scope[CALLER]
        reason = asked.reason or "requested by the operator"
        operator = caller.name or asked.operator
        await asyncio.to_thread(service.control.emergency_stop, asked.rig, reason, operator)

    # Before it is accepted: nothing that begins after that is missed.
    begun = await asyncio.to_thread(view.check_now)
    await socket.accept()
    try:
        for found in begun:
            await socket.send_bytes(found)
        async with _while_there(socket, stop) as gone:
            while not gone.done():
                for found in await asyncio.to_thread(view.check_now):
                    await socket.send_bytes(found)
                await asyncio.wait({gone}, timeout=LOOK_S)
    except ModallabError as error:
        await socket.close(WRONG, error.what[:REASON])
    finally:
        view.close()


@contextlib.asynccontextmanager
async def _while_there(socket: WebSocket, stop: Stop | None = None) -> AsyncGenerator["asyncio.Future[None]"]:
    """Done once the other side has left; that it leaves while something is sent to it is no error."""
    gone = asyncio.ensure_future(_until_gone(socket, stop))
    try:
        with contextlib.suppress(WebSocketDisconnect):
            yield gone
    finally:
        gone.cancel()


async def _until_gone(socket: WebSocket, stop: Stop | None) -> None:
    # Only who listens hears that the other side has left; and nothing but a stop is expected.
    with contextlib.suppress(WebSocketDisconnect):
        while True:
            text = await socket.receive_text()
            if stop is not None:
                with contextlib.suppress(ValidationError):
                    await _stop_pressed(stop, StopRequest.model_validate_json(text))


async def _stop_pressed(stop: Stop, asked: StopRequest) -> None:
    try:
        await stop(asked)
    except ModallabError as error:
        # The viewer asks in other ways too, and hears it there.
        LOG.warning("emergency stop by WebSocket: %s", error)


async def _until_gone_or_found(found: AsyncGenerator[T], gone: "asyncio.Future[None]") -> AsyncGenerator[T]:
    """What comes, as long as the other side is there."""
    try:
        while True:
            following = asyncio.ensure_future(anext(found))
            await asyncio.wait({following, gone}, return_when=asyncio.FIRST_COMPLETED)
            if gone.done():
                following.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await following
                return
            yield following.result()
    except StopAsyncIteration:
        return
    finally:
        await found.aclose()
