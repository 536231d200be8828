"""The port of the service and its connections: how many, and how long one may leave a request unfinished."""

import asyncio
import os
import socket
import sys
import time
from contextlib import suppress
from typing import Any

import psutil
from uvicorn.protocols.http.h11_impl import H11Protocol

from modallab.service.api.access import TRUSTED
from modallab.service.errors import ServiceError

PATIENCE_S = 15.0
"""Until the head and the body of a request must be there."""
LOOK_S = 1.0
MOST = 8000
RESERVE = 256
"""Descriptors that are kept for the database, samples, results and whatever a request needs."""
_BACKLOG = 1024
_AGAIN_S = 0.1
_HOLDER_PATIENCE_S = 2.0
"""A process that has just been ended lets go of its port within this time."""


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


def raise_connection_limit() -> int:
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


def bound_socket(host: str, port: int) -> socket.socket:
    """A socket that listens there.

    Raises:
        ServiceError: the port is taken; it says by whom.
    """
    end = time.monotonic() + _HOLDER_PATIENCE_S
    while True:
        try:
            return _bind_socket(host, port)
        except OSError as error:
            if time.monotonic() > end:
                raise port_taken_error(port, error) from error
            time.sleep(_AGAIN_S)


def _bind_socket(host: str, port: int) -> socket.socket:
    # Bound here, so that requests wait in line while the REST process is started again.
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # The protocol is named: asyncio sends small answers at once (TCP_NODELAY) only on sockets that name it. Without,
    # each answer in two parts, head and body, waits 40 ms for the client's delayed acknowledgement.
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        if os.name == "posix":
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(_BACKLOG)
    except OSError:
        listener.close()
        raise
    return listener


def port_taken_error(port: int, error: OSError) -> ServiceError:
    """What to raise where a port cannot be had."""
    return ServiceError(
        f"cannot listen on port {port}: {error.strerror}{_holder_of_port(port)}",
        where="port",
        remedy="end that process, or name another port",
    )


def _holder_of_port(port: int) -> str:
    # Of other people's processes the system may say nothing.
    with suppress(psutil.Error, OSError):
        for one in psutil.net_connections("tcp"):
            if one.status == psutil.CONN_LISTEN and one.laddr and one.laddr[1] == port and one.pid:
                return f"; process {one.pid} holds it: {' '.join(psutil.Process(one.pid).cmdline())[:200]}"
    return ""
