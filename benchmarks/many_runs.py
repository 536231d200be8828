"""Runs in a row on one service: whether its memory and the times of its lists stay flat.

Ten runs a campaign, as fast as it goes on a simulated bench in its own time. Now and then: the memory of each process,
and how long each list takes (median of 20). At the end the second tenth of the runs is compared with the last.

    python benchmarks/many_runs.py --runs 2000
"""

import argparse
import statistics
import sys
import tempfile
import time
from pathlib import Path

import httpx
import psutil

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from service_process import ServiceProcess

from modallab.core.plan import ImpactPlan

BENCH = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"
PLAN = ImpactPlan(points=(10,), hits=1)
A_CAMPAIGN = 10
LISTS = ("campaigns", "campaigns/{campaign}", "campaigns/{campaign}/runs", "events?limit=100", "audit", "rigs")
MEMORY, TIMES = 1.1, 1.5
"""By how much the last may stand above the first."""
Look = dict[str, float]


def memory(service: ServiceProcess) -> Look:
    """MB that each process has in memory, for itself alone where the system says that."""
    found: Look = {}
    for name, pid in service.client.processes().items():
        about = psutil.Process(pid).memory_full_info()
        found[f"{name} [MB]"] = getattr(about, "uss", about.rss) / 1e6
    return found


def list_times(service: ServiceProcess, campaign: str) -> Look:
    """ms that each list takes."""
    found: Look = {}
    headers = {"Authorization": f"Bearer {service.token}"}
    with httpx.Client(base_url=f"{service.url}/api/v1/", headers=headers, timeout=60.0) as client:
        for path in LISTS:
            took: list[float] = []
            for _ in range(20):
                began = time.perf_counter()
                client.get(path.format(campaign=campaign)).raise_for_status()
                took.append(time.perf_counter() - began)
            found[f"{path.replace('{campaign}', 'ID')} [ms]"] = 1e3 * statistics.median(took)
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="no further run after so long")
    arguments = parser.parse_args()
    looks: list[Look] = []
    done, every = 0, max(1, arguments.runs // 40)
    began = time.monotonic()
    with (
        tempfile.TemporaryDirectory() as folder,
        ServiceProcess(Path(folder) / "data", "--no-jobs", bench=BENCH) as service,
        service.client.take_lease(service.rig, "Ada") as lease,
    ):
        campaign = ""
        while done < arguments.runs and time.monotonic() - began < 60 * arguments.minutes:
            if done % A_CAMPAIGN == 0:
                campaign = service.client.create_campaign(f"session {done // A_CAMPAIGN}", service.rig).id
            service.client.wait_until_idle(service.rig)
            run = service.client.start_run(campaign, PLAN, lease).id
            for _ in service.client.follow_run(run):
                pass
            ended = service.client.run(run)
            assert ended.state == "done", ended
            assert ended.accepted == 1
            done += 1
            if done % every == 0:
                looks.append(memory(service) | list_times(service, campaign))
                print(f"{done}: " + ", ".join(f"{name} {value:.1f}" for name, value in looks[-1].items()), flush=True)
    good = report(looks)
    load = psutil.getloadavg()[0] / psutil.cpu_count()
    took = time.monotonic() - began
    print(f"{done} runs, {took / done:.2f} s each; {load:.1f} times more work than processors")
    return 0 if good else 1


def report(looks: list[Look]) -> bool:
    """Whether memory and times stay; the first looks, while caches fill, are left out."""
    tenth = max(1, len(looks) // 10)
    first, last = looks[tenth : 2 * tenth], looks[-tenth:]
    good = True
    for name in looks[-1]:
        # The least of several: other work on the machine only makes it longer.
        before, after = (min(look[name] for look in part if name in look) for part in (first, last))
        flat = after <= (MEMORY if "MB" in name else TIMES) * before
        good = good and flat
        print(f"{name}: {before:.1f} -> {after:.1f}{'' if flat else ', not flat'}")
    return good


if __name__ == "__main__":
    sys.exit(main())
