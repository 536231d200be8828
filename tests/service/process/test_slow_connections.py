"""Connections that send nothing, or never all of it, keep nobody else waiting and are let go."""

import asyncio
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack
from threading import Thread

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from modallab.service.process import connections
from modallab.service.process.connections import RESERVE, bound_socket, guarded_protocol

ROOM = 64


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[str, int]]:
    """A server that has room for `ROOM` connections, and waits for half a second."""
    monkeypatch.setattr(connections, "PATIENCE_S", 0.5)
    monkeypatch.setattr(connections, "LOOK_S", 0.1)
    app = FastAPI()

    @app.post("/")
    async def answer(body: dict[str, int]) -> int:
        return body["n"]

    listener = bound_socket("127.0.0.1", 0)
    server = uvicorn.Server(uvicorn.Config(app, log_config=None, http=guarded_protocol(ROOM + RESERVE), lifespan="off"))
    thread = Thread(target=lambda: asyncio.run(server.serve([listener])), daemon=True)
    thread.start()
    yield listener.getsockname()
    server.should_exit = True
    thread.join(10)


def ask(place: tuple[str, int]) -> httpx.Response:
    return httpx.post(f"http://{place[0]}:{place[1]}/", json={"n": 3}, timeout=5.0)


def let_go(slow: socket.socket, more: bytes) -> bool:
    """Whether the server has closed it; else it gets some more."""
    try:
        slow.sendall(more)
        return slow.recv(1) == b""
    except TimeoutError:
        return False
    except OSError:
        return True


def test_more_than_there_is_room_for_give_way_to_a_new_one(place: tuple[str, int]) -> None:
    with ExitStack() as idle:
        for _ in range(4 * ROOM):
            idle.enter_context(socket.create_connection(place, 5.0))
        assert ask(place).json() == 3


@pytest.mark.parametrize(
    "begun",
    [b"", b"POST / HTTP/1.1\r\nHost: x\r\nX-Slow: ", b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 999\r\n\r\n{"],
    ids=["nothing", "a head", "a body"],
)
def test_a_request_that_never_ends_is_let_go(place: tuple[str, int], begun: bytes) -> None:
    with socket.create_connection(place, 5.0) as slow:
        slow.sendall(begun)
        slow.settimeout(0.05)
        end = time.monotonic() + 10.0
        while not let_go(slow, b"x" if begun else b""):
            assert time.monotonic() < end, "it is kept"
    assert ask(place).json() == 3


def test_a_whole_request_has_all_the_time_that_it_needs(place: tuple[str, int]) -> None:
    with httpx.Client(base_url=f"http://{place[0]}:{place[1]}") as client:
        assert client.post("/", json={"n": 1}).json() == 1
        assert client.post("/", json={"n": 2}).json() == 2
