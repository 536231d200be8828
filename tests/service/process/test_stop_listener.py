"""The emergency stop's own listener: it asks for nothing, and no page of another site can use it."""

from collections.abc import Iterator

import httpx
import pytest

from modallab.core.errors import BenchError
from modallab.service.errors import NotFoundError
from modallab.service.process.stop_listener import StopListener

Called = list[tuple[str | None, str]]


@pytest.fixture
def called() -> Called:
    return []


@pytest.fixture
def url(called: Called) -> Iterator[str]:
    def stop(rig: str | None, _reason: str, operator: str) -> tuple[str, ...]:
        called.append((rig, operator))
        if rig == "none":
            raise NotFoundError("there is no rig 'none'")
        if rig == "broken":
            raise BenchError("the output cannot be reached", remedy="switch the amplifier off")
        return ("link",)

    listener = StopListener("127.0.0.1", 0, stop)
    try:
        yield f"http://127.0.0.1:{listener.port}/emergency-stop"
    finally:
        listener.close()


def test_a_post_stops_and_a_look_does_not(url: str, called: Called) -> None:
    page = httpx.get(f"{url}?rig=link")
    assert page.status_code == 200
    assert page.headers["content-type"].startswith("text/html")
    assert "<form method=post>" in page.text
    assert httpx.get(url.removesuffix("emergency-stop")).status_code == 404
    assert called == []
    assert httpx.post(url).json() == {"stopped": ["link"]}
    assert httpx.post(f"{url}?rig=link&operator=Ada").status_code == 200
    assert called == [(None, "unknown"), ("link", "Ada")]


def test_what_could_not_be_stopped_is_said_with_what_to_do(url: str) -> None:
    failed = httpx.post(f"{url}?rig=broken")
    assert failed.status_code == 500
    assert failed.json()["remedy"] == "switch the amplifier off"
    assert httpx.post(f"{url}?rig=none").status_code == 404


def test_its_own_page_may_press_the_button(url: str, called: Called) -> None:
    origin = url.removesuffix("/emergency-stop")
    assert httpx.post(url, headers={"Origin": origin}, data={}).status_code == 200
    assert called == [(None, "unknown")]


def test_a_page_of_another_site_stops_nothing(url: str, called: Called) -> None:
    assert httpx.post(url, headers={"Origin": "https://evil.example"}).status_code == 403
    assert called == []


def test_a_client_that_sends_nothing_keeps_nobody_waiting(url: str) -> None:
    import socket
    from urllib.parse import urlsplit

    place = urlsplit(url)
    with socket.create_connection((place.hostname, place.port)):
        assert httpx.post(url, timeout=5.0).status_code == 200
