"""The page itself: its size, its forms, its tabs, a sine test and the stop."""

from collections.abc import Callable

import pytest
from page_browser import LONG_SINE, Watched
from service_process import ServiceProcess

Open = Callable[..., Watched]
FIRST_VIEW_BYTES = 200_000
SINE = {"sine-frequencies_hz": "20, 30", "sine-settle_s": "1", "sine-wait_s": "0.2"}


def test_the_first_view_is_small_and_says_how_the_bench_stands(operator: Open) -> None:
    ada = operator()
    assert ada.page.inner_text(".facts div:nth-child(3) dd") == "ready"
    assert ada.page.locator("table tbody tr").count() == 11
    ada.page.wait_for_selector(".lamp.good:text-is('in range')")
    ada.picture("bench")
    assert 20_000 < ada.bytes < FIRST_VIEW_BYTES


@pytest.mark.thorough("opens many tabs of the page")
def test_all_tabs_share_one_stream_of_events(operator: Open, served: ServiceProcess) -> None:
    ada = operator()
    streams: list[str] = []
    ada.context.on("request", lambda r: streams.append(r.url) if "/events/stream" in r.url else None)
    tabs = [ada.page, *(ada.context.new_page() for _ in range(2))]
    for tab in tabs[1:]:
        tab.goto(served.url + "/page/")
        tab.wait_for_selector("header .lamp.good")
    found = ada.page.context.browser.new_browser_cdp_session().send("Target.getTargets")["targetInfos"]  # type: ignore[union-attr]
    assert [one["type"] for one in found].count("shared_worker") == 1
    assert streams == []
    tabs[2].keyboard.press("Escape")
    for tab in tabs:
        tab.wait_for_selector(".alarm")
    tabs[0].click("text=Bench checked: reset")
    for tab in tabs:
        tab.wait_for_selector(".alarm", state="detached")


def test_a_sine_test_and_the_stop(operator: Open, served: ServiceProcess) -> None:
    ada = operator()
    ada.begin("Sine test", SINE)
    ada.page.wait_for_selector(".prompt .large:text-is('Done')")
    assert ada.page.locator("tbody td.good").count() == 2
    ada.page.wait_for_selector("[aria-label='FRFs so far'][data-points]")
    ada.picture("sine")
    ada.begin("Sine test", LONG_SINE)
    ada.page.wait_for_selector(".prompt[data-mood=ready]")
    ada.page.click("button.stop")
    ada.page.wait_for_selector(".prompt .large:text-is('Stopped')")
    assert served.client.rigs()[0].trip is not None
    ada.view("Bench")
    ada.page.click("text=Bench checked: reset")
    ada.page.wait_for_selector(".alarm", state="detached")


@pytest.mark.thorough("a third whole test on the page")
def test_a_chirp_is_planned_and_recorded(operator: Open) -> None:
    ada = operator()
    ada.view("Broadband test")
    ada.page.wait_for_selector("form.plan p.good:has-text('blocks, about')")
    ada.page.select_option("#f-broadband-signal", "chirp")
    for name, text in {"band_hz": "5, 200", "blocks": "3", "settle_s": "1", "wait_s": "0.2"}.items():
        ada.page.fill(f"#f-broadband-{name}", text)
    ada.picture("broadband-plan")
    ada.page.click("form.plan button.main:enabled")
    ada.page.wait_for_selector(".prompt .large:text-is('Done')")
    assert ada.page.locator("[aria-label='Blocks so far'] td.good").count() == 3
    ada.page.wait_for_selector("[aria-label='FRFs so far'][data-points]")
    ada.picture("broadband")


def test_the_form_checks_as_one_types(operator: Open) -> None:
    ada = operator()
    ada.view("Impact test")
    ada.page.fill("#f-impact-hits", "2.5")
    assert ada.page.inner_text("#f-impact-hits-wrong") == "2.5 is no whole number"
    ada.page.fill("#f-impact-hits", "2")
    ada.page.fill("#f-impact-points", "77")
    ada.page.wait_for_selector("form.plan p.bad:has-text('77 is not on the rig')")
    assert ada.page.is_disabled("form.plan button.main")
