"""Whether a tab that is left open grows: its heap after a collection, every so often, while a test goes on and on.

The bench's clock runs faster than the real one, so that an hour of hits needs less.

    python benchmarks/page/memory.py --bench-minutes 60 --speed 20
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "helpers"))

from page_browser import Watched, browsing, chromium
from service_process import ServiceProcess

LOOKS = 12


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench-minutes", type=float, default=60.0)
    parser.add_argument("--speed", type=float, default=20.0)
    arguments = parser.parse_args()
    program = chromium()
    if program is None:
        raise SystemExit("this machine has no chromium")
    bench = f"sim://cantilever?seed=3&zeta=0.02&bad_hits=0.2&pace=1&speed={arguments.speed:g}&reaction_s=0.5,1"
    with (
        tempfile.TemporaryDirectory() as name,
        browsing(program) as browser,
        ServiceProcess(Path(name) / "data", "--no-jobs", bench=bench) as service,
    ):
        page = Watched(browser, service.url + service.client.login_link().path)
        page.begin("Impact test", {"impact-points": "10, 6, 3", "impact-hits": "2000"})
        page.page.wait_for_selector("[aria-label='FRFs so far'][data-averages]")
        session = page.context.new_cdp_session(page.page)
        session.send("Performance.enable")
        heaps: list[float] = []
        for _ in range(LOOKS):
            page.page.wait_for_timeout(60e3 * arguments.bench_minutes / arguments.speed / LOOKS)
            session.send("HeapProfiler.collectGarbage")
            found = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
            heaps.append(found["JSHeapUsedSize"] / 1e6)
        hits = page.page.inner_text(".togo")
        page.close()
    slope = float(np.polyfit(np.linspace(0, arguments.bench_minutes / 60, LOOKS), heaps, 1)[0])
    print(
        f"{arguments.bench_minutes:g} min of the bench, {hits}: heap {heaps[0]:.1f} MB at first, {heaps[-1]:.1f} MB at"
        f" last, most {max(heaps):.1f} MB, {slope:+.2f} MB an hour;"
        f" load {os.getloadavg()[0]:.0f} on {os.cpu_count()} cores"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
