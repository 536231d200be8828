"""What an operator does on the page, in a real browser, with a real service and the simulated bench behind it."""

import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from page_browser import Watched
from playwright.sync_api import Browser
from service_process import ServiceProcess

Open = Callable[..., Watched]
VIEWS = ("Bench", "Impact test", "Sine test", "Model", "Gap", "Campaigns")
FIRST_VIEW_BYTES = 200_000
IMPACT = {"impact-points": "10, 6", "impact-hits": "2"}
SINE = {"sine-frequencies_hz": "20, 30", "sine-settle_s": "1", "sine-wait_s": "0.2"}
SAID = """selector => { window.said = []; const seen = () => document.querySelector(selector)
    && window.said.push(document.querySelector(selector).textContent);
    new MutationObserver(seen).observe(document.body, {childList: true, subtree: true, characterData: true}); }"""
HIT = "section[aria-label='The last hit'] .large"
SHOWN = "main section.panel, main .prompt"
SERIOUS = ("serious", "critical")


def run_of(served: ServiceProcess) -> str | None:
    return served.client.rigs()[0].run


def test_the_first_view_is_small_and_says_how_the_bench_stands(operator: Open) -> None:
    ada = operator()
    assert ada.page.inner_text(".facts div:nth-child(3) dd") == "ready"
    assert ada.page.locator("table tbody tr").count() == 11
    assert 20_000 < ada.bytes < FIRST_VIEW_BYTES


def test_a_whole_impact_test_with_a_bad_hit(operator: Open, served: ServiceProcess) -> None:
    ada = operator()
    ada.page.evaluate(SAID, HIT)
    ada.begin("Impact test", IMPACT)
    ada.page.wait_for_selector(".prompt .large:text-is('Strike point 10')")
    ada.page.wait_for_selector(".prompt .large:text-is('Done')")
    said = ada.page.evaluate("window.said")
    assert {"Good", "Rejected"} <= set(said)
    assert ada.page.inner_text(".togo") == "4 of 4 good hits"
    ada.page.wait_for_selector("[aria-label='FRFs so far'][data-points='10 6'][data-averages='2']")
    run = served.client.campaigns()[0].runs[-1]
    assert served.client.run(run).accepted == 4


def test_a_sine_test_and_the_stop(operator: Open, served: ServiceProcess) -> None:
    ada = operator()
    ada.begin("Sine test", SINE)
    ada.page.wait_for_selector(".prompt .large:text-is('Done')")
    assert ada.page.locator("tbody td.good").count() == 2
    ada.page.wait_for_selector("[aria-label='FRFs so far'][data-points]")
    ada.begin("Sine test", SINE | {"sine-settle_s": "20"})
    ada.page.wait_for_selector(".prompt[data-mood=ready]")
    ada.page.click("button.stop")
    ada.page.wait_for_selector(".prompt .large:text-is('Stopped')")
    trip = served.client.rigs()[0].trip
    assert trip is not None
    ada.view("Bench")
    ada.page.click("text=I have looked: reset")
    ada.page.wait_for_selector(".alarm", state="detached")
    ada.page.keyboard.press("Escape")
    ada.page.wait_for_selector(".alarm")
    ada.page.click("text=I have looked: reset")
    ada.page.wait_for_selector(".alarm", state="detached")


def test_the_form_checks_as_one_types(operator: Open) -> None:
    ada = operator()
    ada.view("Impact test")
    ada.page.fill("#f-impact-hits", "2.5")
    assert ada.page.inner_text("#f-impact-hits-wrong") == "2.5 is no whole number"
    ada.page.fill("#f-impact-hits", "2")
    ada.page.fill("#f-impact-points", "77")
    ada.page.wait_for_selector("form.plan p.bad:has-text('77 is not on the rig')")
    assert ada.page.is_disabled("form.plan button.main")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_everybody_can_read_every_view(operator: Open, scheme: str) -> None:
    ada = operator(color_scheme=scheme)
    for view in VIEWS:
        ada.view(view)
        ada.page.wait_for_selector(SHOWN)
        found = Axe().run(ada.page).response["violations"]
        assert [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in SERIOUS] == [], view


def test_on_a_phone_nothing_is_wider_than_the_screen(operator: Open) -> None:
    ada = operator(viewport={"width": 390, "height": 800})
    for view in VIEWS:
        ada.view(view)
        assert ada.page.evaluate("document.documentElement.scrollWidth") <= 390, view
        assert ada.page.is_visible("button.stop")


def test_a_service_that_was_killed_and_came_back(browser: Browser, tmp_path: Path) -> None:
    folder = tmp_path / "killed" / "data"
    folder.parent.mkdir()
    bench = "sim://cantilever?seed=3&zeta=0.05&bad_hits=0&pace=1&reaction_s=20,21"
    with ServiceProcess(folder, "--no-jobs", bench=bench) as first:
        ada = Watched(browser, first.url + first.client.login_link().path)
        ada.begin("Impact test", IMPACT)
        ada.page.wait_for_selector(".prompt[data-mood=ready]")
        first.process.send_signal(signal.SIGKILL)
        first.process.wait()
        ada.page.wait_for_selector("header .lamp.bad")
        port = first.url.rpartition(":")[2]
    with ServiceProcess(folder, "--no-jobs", "--port", port, bench=bench):
        ada.page.wait_for_selector("header .lamp.good")
        ada.page.wait_for_selector(".prompt .large:text-is('Ended early')")
        assert [wrong for wrong in ada.wrong if not wrong.startswith("console:")] == []
        ada.close()
