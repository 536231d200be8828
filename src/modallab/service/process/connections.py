"""Connections of the REST process: how many, and how long one may leave a request unfinished."""

import asyncio
import sys
import time
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

from modallab.service.api.access import TRUSTED

PATIENCE_S = 15.0
"""Until the head and the body of a request must be there."""
LOOK_S = 1.0
MOST = 8000
RESERVE = 256
"""Descriptors that are kept for the database, samples, results and whatever a request needs."""


class ConnectionLimit:
    """All connections. Where there are too many, the oldest of those without a token gives way to a new one."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._open: dict[GuardedHttp, None] = {}
        self._looking: asyncio.TimerHandle | None = None

    def enter(self, connection: "GuardedHttp") -> None:
        """A new connection."""
        if len(self._open) >= self._most:
            oldest = next((other for other in self._open if not other.trusted), connection)
            self._drop(oldest)
            if oldest is connection:
                return
        self._open[connection] = None
        if self._looking is None:
            self._looking = connection.loop.call_later(LOOK_S, self._look, connection.loop)

    def leave(self, connection: "GuardedHttp") -> None:
        """It is closed, or speaks another protocol now."""
        self._open.pop(connection, None)

    def _look(self, loop: asyncio.AbstractEventLoop) -> None:
        limit = time.monotonic() - PATIENCE_S
        for late in [connection for connection in self._open if connection.unfinished_since_s < limit]:
            self._drop(late)
        self._looking = loop.call_later(LOOK_S, self._look, loop) if self._open else None

    def _drop(self, connection: "GuardedHttp") -> None:
        self.leave(connection)
        # Without a word: whoever does not read would keep it open.
        connection.transport.abort()


class GuardedHttp(H11Protocol):
    """A connection that does not keep anyone waiting for ever."""

    crowd: ConnectionLimit

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """As uvicorn; the first request is due from now on."""
        super().connection_made(transport)
        self._due_s: float | None = time.monotonic()
        self.crowd.enter(self)

    def data_received(self, data: bytes) -> None:
        """As uvicorn."""
        super().data_received(data)
        cycle: Any = self.cycle
        if cycle is None or cycle.response_complete or cycle.more_body:
            self._due_s = self._due_s or time.monotonic()
        else:
            self._due_s = None

    def connection_lost(self, exc: Exception | None) -> None:
        """As uvicorn."""
        super().connection_lost(exc)
        self.crowd.leave(self)

    def handle_websocket_upgrade(self, event: Any) -> None:
        """As uvicorn, which hands it on to another protocol."""
        self.crowd.leave(self)
        super().handle_websocket_upgrade(event)

    @property
    def trusted(self) -> bool:
        """Whether its last request carried the token."""
        return bool(self.scope) and TRUSTED in self.scope

    @property
    def unfinished_since_s(self) -> float:
        """Since when a part of a request is due; infinite if none is."""
        return float("inf") if self._due_s is None else self._due_s


def guarded_protocol(descriptors: int) -> type[GuardedHttp]:
    """The protocol for a server of a process that may have so many descriptors."""
    crowd = ConnectionLimit(max(64, min(MOST, descriptors - RESERVE)))
    return type("Connection", (GuardedHttp,), {"crowd": crowd})


ENOUGH = 16384


def raise_limit() -> int:
    """Let this process, and those that it starts, have as many as the system allows; how many that is."""
    if sys.platform == "win32":
        return ENOUGH
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY:
        return ENOUGH
    allowed = ENOUGH if hard == resource.RLIM_INFINITY else min(hard, ENOUGH)
    if soft < allowed:
        resource.setrlimit(resource.RLIMIT_NOFILE, (allowed, hard))
    return max(soft, allowed)
