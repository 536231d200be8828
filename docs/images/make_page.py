"""Makes the pictures of the operator's page: records a campaign by the page on the simulated bench.

PYTHONPATH=tests/helpers python docs/images/make_page.py docs/images
"""

import argparse
import tempfile
from pathlib import Path

from page_browser import Watched, browsing, chromium
from playwright.sync_api import Browser
from service_process import ServiceProcess

BENCH = "sim://cantilever?seed=3&zeta=0.01&bad_hits=0.2&pace=1&speed=8&reaction_s=0.3,0.5"
IMPACT = {"impact-points": "10, 6, 3", "impact-hits": "3"}
SINE = {"sine-frequencies_hz": "4, 5, 8, 20, 29, 30, 31, 33, 60, 86, 88, 95", "sine-settle_s": "4", "sine-wait_s": "2"}
DESK = {"width": 1360, "height": 860}
PHONE = {"width": 390, "height": 844}
DONE = ".prompt .large:text-is('Done')"
PATIENCE_MS = 900_000


def main() -> None:
    """Make them all."""
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path)
    parser.add_argument("--no-gap", action="store_true", help="the diagnosis takes minutes")
    arguments = parser.parse_args()
    program = chromium()
    if program is None:
        raise SystemExit("this machine has no chromium")
    with tempfile.TemporaryDirectory() as folder, browsing(program) as browser:
        data = Path(folder) / "page" / "data"
        data.parent.mkdir()
        with ServiceProcess(data, "--workers", "1", bench=BENCH) as served:
            _shoot(browser, served, arguments.out, gap=not arguments.no_gap)


def _shoot(browser: Browser, served: ServiceProcess, out: Path, *, gap: bool) -> None:
    def opened(**options: object) -> Watched:
        return Watched(browser, served.url + served.client.login_link().path, **options)

    ada, dark, phone = opened(viewport=DESK), opened(viewport=DESK, color_scheme="dark"), opened(viewport=PHONE)
    for one in (ada, dark, phone):
        one.page.set_default_timeout(PATIENCE_MS)
    ada.view("Impact test")
    ada.page.wait_for_selector("form.plan p.good")
    ada.shoot(out / "page-plan.png")
    ada.begin("Impact test", IMPACT)
    ada.page.wait_for_selector(".prompt[data-mood=rejected]")
    ada.shoot(out / "page-impact.png")
    dark.view("Impact test")
    phone.view("Impact test")
    for one, name in ((phone, "page-phone"), (dark, "page-impact-dark")):
        one.page.wait_for_selector(".prompt[data-mood=ready]")
        one.shoot(out / f"{name}.png")
    ada.view("Bench")
    ada.page.wait_for_selector(".lamp.good:text-is('in range')")
    ada.shoot(out / "page-bench.png")
    ada.view("Impact test")
    ada.page.wait_for_selector(DONE)
    ada.shoot(out / "page-frf.png", whole=True)
    ada.begin("Sine test", SINE)
    ada.page.wait_for_selector("tbody tr:nth-child(7) td.good")
    ada.shoot(out / "page-sine.png", whole=True)
    ada.page.wait_for_selector(DONE)
    ada.view("Model")
    ada.page.wait_for_selector("h2:has-text('Measured and regenerated, impact')")
    ada.page.wait_for_timeout(500)
    ada.shoot(out / "page-model.png", whole=True)
    ada.view("Campaigns")
    ada.page.click("button:text-is('Open')")
    ada.page.wait_for_selector("tbody input[type=checkbox]")
    for box in ada.page.query_selector_all("tbody input[type=checkbox]"):
        box.check()
    ada.page.click("text=Compare two runs")
    ada.page.wait_for_selector("h2:text-is('Compared')")
    ada.page.wait_for_timeout(500)
    ada.shoot(out / "page-campaigns.png", whole=True)
    if gap:
        ada.view("Gap")
        ada.page.click("button:text-is('Diagnose')")
        ada.page.wait_for_selector(".verdict")
        ada.shoot(out / "page-gap.png", whole=True)
    assert [wrong for one in (ada, dark, phone) for wrong in one.wrong] == []


if __name__ == "__main__":
    main()
