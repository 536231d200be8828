"""What watching live channels costs, and whether the page keeps up: processor time of the service, pictures a second.

The bench is the device of `benchmarks/many_channels.py`: noise and hits on any number of channels in real time. A run
is on, and the bench view is open in a browser without a window. What the REST process takes without it is taken off.

    python benchmarks/page/watched.py --channels 11 --rate 2000 --seconds 30
    python benchmarks/page/watched.py --channels 64 --rate 51200 --seconds 30
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

import psutil

sys.path.insert(0, str(Path(__file__).parent.parent))
sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "helpers"))

from page_browser import Watched, browsing, chromium
from service_process import ServiceProcess

from many_channels import ENDED, ENTRY, busy_s, rig_file
from modallab.core.plan import HitAcceptance, ImpactPlan

COUNT = """() => { window.pictures = 0; const before = CanvasRenderingContext2D.prototype.clearRect;
    const first = document.querySelector("canvas.strip");
    CanvasRenderingContext2D.prototype.clearRect = function (...all) {
        window.pictures += Number(this.canvas === first); return before.apply(this, all); }; }"""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--channels", type=int, default=11)
    parser.add_argument("--rate", type=float, default=2000.0)
    parser.add_argument("--seconds", type=float, default=30.0)
    arguments = parser.parse_args()
    program = chromium()
    if program is None:
        raise SystemExit("this machine has no chromium")
    with tempfile.TemporaryDirectory() as name, browsing(program) as browser:
        folder = Path(name)
        entry = folder / "many_channels-0.dist-info"
        entry.mkdir()
        (entry / "METADATA").write_text("Metadata-Version: 2.1\nName: many_channels\nVersion: 0\n")
        (entry / "entry_points.txt").write_text(ENTRY)
        env = {
            "PYTHONPATH": os.pathsep.join((name, str(Path(__file__).parent.parent))),
            "MANY_BEGAN": str(folder / "began"),
        }
        rig = rig_file(folder, arguments.channels)
        with ServiceProcess(folder / "data", "--rig", str(rig), "--no-jobs", env=env) as service:
            run = begin(service, arguments.rate)
            alone = share_of(service, arguments.seconds)
            page = Watched(browser, service.url + service.client.login_link().path)
            messages: list[int] = []
            page.page.on("websocket", lambda one: one.on("framereceived", lambda _: messages.append(1)))
            page.page.reload()
            page.page.wait_for_selector(".lamp.good:text-is('in range')")
            page.page.evaluate(COUNT)
            messages.clear()
            watched = share_of(service, arguments.seconds)
            page.page.wait_for_timeout(1)
            pictures = page.page.evaluate("window.pictures") / arguments.seconds
            page.close()
            view = service.client.run(run)
    load = os.getloadavg()[0]
    print(
        f"{arguments.channels} channels at {arguments.rate:g} Hz, run {view.state}: {pictures:.1f} pictures a second of"
        f" {len(messages) / arguments.seconds:.1f} messages;"
        f" the REST process takes {100 * (watched - alone):.1f} % of a core for the page, {100 * alone:.1f} % without;"
        f" load {load:.0f} on {psutil.cpu_count()} cores"
    )
    return 0


def begin(service: ServiceProcess, rate_hz: float) -> str:
    lab = service.client
    campaign = lab.create_campaign("watched", service.rig)
    lease = lab.take_lease(service.rig, "Ada", ttl_s=3600)
    plan = ImpactPlan(points=(1,), hits=1000, rate_hz=rate_hz, acceptance=HitAcceptance(max_force_n=490.0))
    run = lab.start_run(campaign.id, plan, lease).id
    while (view := lab.run(run)).state not in ("acquiring", "armed"):
        if view.state in ENDED:
            raise SystemExit(f"run {view.state}: {view.reason}")
        time.sleep(0.05)
    return run


def share_of(service: ServiceProcess, seconds: float) -> float:
    """Of a core that the REST process takes."""
    pid = service.client.processes()["api"]
    before, began_s = busy_s(pid), time.monotonic()
    time.sleep(seconds)
    return (busy_s(pid) - before) / (time.monotonic() - began_s)


if __name__ == "__main__":
    sys.exit(main())
