"""The port of the service: bound before anything else is started; and who holds it, if it is taken."""

import os
import socket
import time
from contextlib import suppress

import psutil

from modallab.service.errors import ServiceError

BACKLOG = 1024
AGAIN_S = 0.1
PATIENCE_S = 2.0
"""A process that has just been ended lets go of its port within this time."""


def bound_socket(host: str, port: int) -> socket.socket:
    """A socket that listens there.

    Raises:
        ServiceError: the port is taken; it says by whom.
    """
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            return _bind_socket(host, port)
        except OSError as error:
            if time.monotonic() > end:
                raise port_taken_error(port, error) from error
            time.sleep(AGAIN_S)


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
        listener.listen(BACKLOG)
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
