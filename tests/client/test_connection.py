"""The client where the connection, or what stands on the way, misbehaves: nothing is done twice, nothing is missed."""

import json
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import httpx
import numpy as np
import pytest

from modallab.client import Client, HeldLease, ServiceProblemError
from modallab.client.client import read_events
from modallab.core.documents.rigs import Lease

Step = Callable[[BaseHTTPRequestHandler], None]
EVENT = {"utc": "", "rig": "link", "campaign": "", "run": "r", "kind": "block", "content": {}}
CAMPAIGN = {"id": "c", "name": "a", "note": "", "rig": "link", "operator": "", "created_utc": "", "revision": 1}
LEASE = Lease(id="l", rig="link", operator="Ada", fence=1, ttl_s=0.02)


@contextmanager
def served(*steps: Step) -> Iterator[tuple[Client, list[dict[str, Any]]]]:
    """A client of something that answers its requests by `steps`, in turn; and what it asked for."""
    asked: list[dict[str, Any]] = []
    left = iter(steps)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append({"path": self.path, **self.headers})
            next(left)(self)
            self.close_connection = True

        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            self.do_GET()

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002
            """Nobody reads it."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    try:
        with Client(f"http://127.0.0.1:{server.server_address[1]}", "t") as client:
            yield client, asked
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def says(status: int, body: bytes, **headers: str) -> Step:
    def answer(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(status)
        for name, value in ({"Content_Length": str(len(body))} | headers).items():
            handler.send_header(name.replace("_", "-"), value)
        handler.end_headers()
        handler.wfile.write(body)

    return answer


def breaks(_handler: BaseHTTPRequestHandler) -> None:
    """Takes the request and answers nothing."""


def streams(*numbers: int, ended: bool = False) -> Step:
    events = [EVENT | {"seq": n} for n in numbers]
    if ended:
        events[-1] |= {"kind": "state", "content": {"state": "done"}}
    text = ": listening\n\n" + "".join(f"id: {e['seq']}\ndata: {json.dumps(e)}\n\n" for e in events)
    # Longer than what is sent: the connection breaks in the middle.
    return says(200, text.encode(), Content_Length=str(len(text) + (0 if ended else 100)))


def test_a_request_that_got_no_answer_is_sent_again_under_the_same_key() -> None:
    with served(breaks, says(201, json.dumps(CAMPAIGN).encode())) as (client, asked):
        assert client.create_campaign("a", "link").id == "c"
    assert len(asked) == 2
    assert asked[0]["Idempotency-Key"] == asked[1]["Idempotency-Key"]
    with served(*[says(201, json.dumps(CAMPAIGN).encode())] * 2) as (client, asked):
        for _ in range(2):
            client.create_campaign("a", "link")
    assert asked[0]["Idempotency-Key"] != asked[1]["Idempotency-Key"]


def test_a_stream_that_breaks_is_taken_up_after_the_last_event() -> None:
    with served(streams(1, 2), streams(3), streams(4, 5, ended=True)) as (client, asked):
        assert [event.seq for event in client.follow_run("r")] == [1, 2, 3, 4, 5]
    assert [httpx.URL(one["path"]).params["after"] for one in asked] == ["0", "2", "3"]


def test_samples_that_arrive_damaged_are_not_given_out() -> None:
    samples = np.arange(12, dtype="<i2").reshape(3, 4)
    good = {"Modallab_Dtype": "<i2", "Modallab_Shape": "3,4", "Modallab_Crc32": str(zlib.crc32(samples.tobytes()))}
    damaged = bytes(samples.tobytes()[:-1]) + b"\xff"
    with served(says(200, samples.tobytes(), **good), says(200, damaged, **good)) as (client, _):
        np.testing.assert_array_equal(client.samples("r", 0), samples)
        with pytest.raises(ValueError, match="block 1 of run r arrived damaged"):
            client.samples("r", 1)


def test_what_is_no_problem_of_the_service_is_reported_with_its_status() -> None:
    with served(says(502, b"<h1>Bad Gateway</h1>")) as (client, _), pytest.raises(ServiceProblemError) as reported:
        client.rigs()
    assert reported.value.problem.status == 502
    assert "status 502" in str(reported.value)


def test_events_are_read_as_the_standard_says() -> None:
    one = json.dumps(EVENT | {"seq": 7}, indent=1).splitlines()
    lines = [": comment", "", "id: 7", "event: block", *(f"data: {line}" for line in one), "", "data: cut off"]
    assert [event.seq for event in read_events(lines)] == [7]


def test_a_lease_is_renewed_until_it_is_given_back() -> None:
    renewed, released = threading.Semaphore(0), list[Lease]()
    with HeldLease(LEASE, lambda _: renewed.release(), released.append) as held:
        assert held.id == "l"
        for _ in range(3):
            assert renewed.acquire(timeout=10)
    assert released == [LEASE]
    assert held.lost is None


def test_a_renewal_that_got_no_answer_is_tried_again_and_one_rejected_is_not() -> None:
    tried, released = threading.Semaphore(0), list[Lease]()
    errors: list[Exception] = [httpx.ReadTimeout("busy"), _rejection()]

    def renew(_lease: Lease) -> None:
        tried.release()
        raise errors.pop(0)

    held = HeldLease(LEASE, renew, released.append)
    for _ in range(2):
        assert tried.acquire(timeout=10)
    end = time.monotonic() + 10
    while held.lost is None and time.monotonic() < end:
        time.sleep(0.01)
    held.close()
    assert isinstance(held.lost, ServiceProblemError)
    assert released == []


def _rejection() -> ServiceProblemError:
    body = {"type": "/problems/lease-needed", "title": "t", "status": 403, "code": "lease-needed", "detail": "over"}
    with served(says(403, json.dumps(body).encode())) as (client, _), pytest.raises(ServiceProblemError) as reported:
        client.rigs()
    return reported.value
