"""How soon the page shows a hit's FRF, and how soon a click on its stop has the output at 0 V.

Hits: from the moment a block is known to the service to the moment its FRF is drawn, on the simulated bench. Stops:
from the click in the browser to the last moment at which the output of the simulated device server, a process of its
own in real time, was not at 0 V; it is looked at over 2 ms, and a fall alone takes up to 31 ms.

    python benchmarks/page/quickness.py --hits 100 --stops 20 --speed 2
"""

import argparse
import os
import sys
import tempfile
import time
from datetime import datetime
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "helpers"))

from ni_server import NiServer
from page_browser import BENCH, Watched, browsing, chromium
from playwright.sync_api import Browser
from service_process import ServiceProcess

from emergency_stop import Bench
from modallab.cli.demo import demo_rig
from modallab.formats.rig.rig_file import dump_rig

DRAWN = """() => { window.drawn = []; new MutationObserver((all) => all.forEach(({target}) =>
    target.dataset.averages && window.drawn.push([Number(target.dataset.averages), Date.now()])))
    .observe(document.body, {subtree: true, attributes: true, attributeFilter: ["data-averages"]}); }"""
CLICKED = "addEventListener('click', () => { window.clicked = Date.now(); }, true)"


def hits(browser: Browser, folder: Path, count: int, speed: float) -> list[float]:
    """ms from each block's event to its FRF, in order."""
    bench = BENCH.replace("bad_hits=0.3", "bad_hits=0").replace("speed=20", f"speed={speed:g}")
    with ServiceProcess(folder / "data", "--no-jobs", bench=bench) as service:
        page = Watched(browser, service.url + service.client.login_link().path)
        page.page.set_default_timeout(3_600_000)
        page.page.evaluate(DRAWN)
        page.begin("Impact test", {"impact-points": "10", "impact-hits": str(count)})
        page.page.wait_for_selector(".prompt .large:text-is('Done')")
        page.page.wait_for_timeout(1000)
        drawn = dict(page.page.evaluate("window.drawn"))
        run = service.client.campaigns()[0].runs[0]
        known = [e for e in service.client.follow_run(run) if e.kind == "block"]
        page.close()
    at = [1e3 * datetime.fromisoformat(event.utc).timestamp() for event in known]
    return [drawn[n] - ms for n, ms in enumerate(at, 1) if n in drawn]


def stops(browser: Browser, folder: Path, count: int, _speed: float) -> list[float]:
    """ms from each click to 0 V."""
    rig, took = demo_rig(), []
    (folder / "rig.yaml").write_text(dump_rig(rig), encoding="utf-8")
    with (
        NiServer(rig, "9215", "--pace", virtual=False) as server,
        ServiceProcess(folder / "data", "--no-jobs", "--rig", str(folder / "rig.yaml"), bench=server.url) as service,
    ):
        server.say("preamplifiers sine")
        bench = Bench(server, service)
        page = Watched(browser, service.url + service.client.login_link().path)
        page.page.evaluate(CLICKED)
        for _ in range(count):
            bench.drive()
            page.page.click("button.stop")
            last = time.time()
            while time.time() - last < 0.3:
                if bench.level(0.002) != 0.0:
                    last = time.time()
            took.append(1e3 * last - page.page.evaluate("window.clicked"))
        page.close()
    return took


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hits", type=int, default=100)
    parser.add_argument("--stops", type=int, default=20)
    parser.add_argument("--speed", type=float, default=2.0, help="of the simulated bench against the clock")
    arguments = parser.parse_args()
    program = chromium()
    if program is None:
        raise SystemExit("this machine has no chromium")
    with tempfile.TemporaryDirectory() as name, browsing(program) as browser:
        for what, measure, n in (("hit to FRF", hits, arguments.hits), ("click to 0 V", stops, arguments.stops)):
            if not n:
                continue
            folder = Path(name) / what.replace(" ", "-")
            folder.mkdir()
            took = measure(browser, folder, n, arguments.speed)
            print(
                f"{what}, {len(took)} of {n}: median {np.median(took):.0f} ms, p99 {np.percentile(took, 99):.0f} ms,"
                f" longest {max(took):.0f} ms; load {os.getloadavg()[0]:.0f} on {os.cpu_count()} cores",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
