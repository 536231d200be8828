"""The service is frozen, or killed, in the middle of a test; the page says so, stops, and comes back."""

import os
import signal
from collections.abc import Callable

import httpx
import pytest
from page_browser import LONG_SINE, Watched
from service_process import ServiceProcess

pytestmark = pytest.mark.thorough("freezes and kills the service behind the page")

Open = Callable[..., Watched]
STOPPED = ".prompt .large:text-is('Stopped')"


def test_the_stop_works_while_the_rest_process_is_frozen(operator: Open, served: ServiceProcess) -> None:
    ada = operator()
    ada.begin("Sine test", LONG_SINE)
    ada.page.wait_for_selector(".prompt[data-mood=ready]")
    frozen = served.client.processes()["api"]
    os.kill(frozen, signal.SIGSTOP)
    try:
        with ada.page.expect_response(lambda response: "/emergency-stop?" in response.url) as stopped:
            ada.page.click("button.stop")
        assert stopped.value.ok
    finally:
        os.kill(frozen, signal.SIGCONT)
    ada.page.wait_for_selector(STOPPED)
    assert ada.page.locator(".message").count() == 0
    ada.view("Bench")
    ada.page.click("text=Bench checked: reset")
    ada.page.wait_for_selector(".alarm", state="detached")


def test_a_service_that_was_killed_and_came_back(operator: Open, served: ServiceProcess) -> None:
    ada = operator()
    ada.begin("Sine test", LONG_SINE)
    ada.page.wait_for_selector(".prompt[data-mood=ready]")
    served.kill_and_restart(lambda: ada.page.wait_for_selector("header .lamp.bad"))
    ada.page.wait_for_selector("header .lamp.good")
    ada.page.wait_for_selector(".prompt .large:text-is('Ended early')")
    assert httpx.get(f"{served.url}/health").json()["status"] == "good"
    # The browser itself notes that nobody answered.
    ada.wrong = [wrong for wrong in ada.wrong if not wrong.startswith("console:")]
