"""Live samples by WebSocket: binary frames, for a look. Who is slow misses some; nobody is waited for."""

import asyncio
import contextlib
from dataclasses import dataclass, field

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from modallab.service.api.router import PREFIX

router = APIRouter(prefix=PREFIX)
QUEUE = 8


@dataclass(eq=False, slots=True)
class Viewer:
    """One who looks."""

    queue: asyncio.Queue[bytes] = field(default_factory=lambda: asyncio.Queue(QUEUE))


class LiveHub:
    """Hands frames to everyone who looks."""

    def __init__(self) -> None:
        self._viewers: set[Viewer] = set()
        self._loop: asyncio.AbstractEventLoop | None = None

    def open(self) -> None:
        """Begin; from the event loop."""
        self._loop = asyncio.get_running_loop()

    def show(self, content: bytes) -> None:
        """Show a frame; from any thread."""
        if self._loop is not None and self._viewers:
            # The loop may be closed by now.
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._hand_out, content)

    def enter(self) -> Viewer:
        """Someone looks."""
        viewer = Viewer()
        self._viewers.add(viewer)
        return viewer

    def leave(self, viewer: Viewer) -> None:
        """He does no more."""
        self._viewers.discard(viewer)

    def _hand_out(self, content: bytes) -> None:
        for viewer in self._viewers:
            if viewer.queue.full():
                viewer.queue.get_nowait()
            viewer.queue.put_nowait(content)


@router.websocket("/live")
async def show_live(socket: WebSocket) -> None:
    """Frames of all rigs; what a frame holds stands at its beginning."""
    hub: LiveHub = socket.app.state.live
    await socket.accept()
    viewer = hub.enter()
    gone = asyncio.ensure_future(_until_gone(socket))
    try:
        while not gone.done():
            waiting = asyncio.ensure_future(viewer.queue.get())
            await asyncio.wait({waiting, gone}, return_when=asyncio.FIRST_COMPLETED)
            if not waiting.done():
                waiting.cancel()
                return
            await socket.send_bytes(waiting.result())
    except WebSocketDisconnect:
        return
    finally:
        hub.leave(viewer)
        gone.cancel()


async def _until_gone(socket: WebSocket) -> None:
    # Nothing is expected; but only who listens hears that the other side has left.
    with contextlib.suppress(WebSocketDisconnect):
        while True:
            await socket.receive_text()
