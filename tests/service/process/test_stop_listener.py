"""The emergency stop's own listener: it asks for nothing, and no page of another site can use it."""

import socket
from collections.abc import Iterator
from contextlib import ExitStack
from urllib.parse import urlsplit

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

    listener = StopListener("127.0.0.1", 0, stop, ("Lab.example",))
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
    place = urlsplit(url)
    with socket.create_connection((place.hostname, place.port)):
        assert httpx.post(url, timeout=5.0).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "other.example", "Origin": "https://other.example"},
        {"Host": "127.0.0.1", "Origin": "https://lab.example"},
        {"Origin": "https://other.example", "X-Forwarded-Host": "other.example"},
        {"Host": "[::1]", "Origin": "http://[::1]:8000"},
    ],
)
def test_behind_a_proxy_the_page_and_the_stop_are_of_one_site(
    url: str, called: Called, headers: dict[str, str]
) -> None:
    assert httpx.post(url, headers=headers).status_code == 200
    assert called == [(None, "unknown")]


def test_a_page_of_the_services_other_port_may_ask_and_press(url: str) -> None:
    page = {"Origin": "http://127.0.0.1:8000"}
    asked = httpx.options(url, headers=page | {"Access-Control-Request-Method": "POST"})
    assert (asked.status_code, asked.headers["access-control-allow-origin"]) == (204, page["Origin"])
    assert "POST" in asked.headers["access-control-allow-methods"]
    pressed = httpx.post(url, headers=page, json={"reason": "smoke"})
    assert (pressed.status_code, pressed.headers["access-control-allow-origin"]) == (200, page["Origin"])
    foreign = httpx.options(url, headers={"Origin": "https://evil.example"})
    assert "access-control-allow-origin" not in foreign.headers


def test_hundreds_that_wait_for_nothing_give_way_to_one_who_stops(url: str, called: Called) -> None:
    place = urlsplit(url)
    with ExitStack() as idle:
        for _ in range(300):
            idle.enter_context(socket.create_connection((place.hostname, place.port), 5.0))
        assert httpx.post(url, timeout=5.0).status_code == 200
    assert called == [(None, "unknown")]


def test_a_body_that_nobody_reads_does_not_cost_the_answer(url: str) -> None:
    assert httpx.post(url, content=bytes(60_000)).json() == {"stopped": ["link"]}
