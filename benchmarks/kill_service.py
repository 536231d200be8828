"""Kills processes of the service at random moments of a sine test, or while a job is computed.

The bench is the simulated NI device server, a process of its own in real time, so that what its output does is seen
from outside. After each kill: the output is at 0 V within 0.5 s (the rig's process) or 1.5 s (any other); every block
that was acknowledged to a client is there with its CRC-32; the run has ended; the service goes on. Jobs must be done.

    python benchmarks/kill_service.py --victim rig --kills 50

`--victim frozen` stops the REST process as a debugger would (SIGSTOP) and lets it go on afterwards.
"""

import argparse
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import httpx
import numpy as np
import psutil

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from kept import Follower, require_kept
from ni_server import NiServer
from service_process import ServiceProcess

from modallab.core.plan import ImpactPlan, SinePlan
from modallab.formats.rig.rig_file import dump_rig, parse_rig

OUTPUT = "cDAQ1Mod4/ao0"
LIMIT_S = {"rig": 0.5, "api": 1.5, "supervisor": 1.5, "frozen": 1.5}
ENDED = ("done", "failed", "aborted")
DRIVE = SinePlan(
    frequencies_hz=tuple(19.0 + n / 4 for n in range(80)), settle_s=1.2, ramp_s=0.3, block_s=0.256, wait_s=0.2
)
HITS = ImpactPlan(points=(10, 3), hits=2)


class Bench:
    """The service on the device server; started again when its supervisor was killed."""

    def __init__(self, server: NiServer, folder: Path) -> None:
        self.server, self.data = server, folder / "data"
        self.rig_file = folder / "rig.yaml"
        self.acknowledged: dict[tuple[str, int], int] = {}
        self.service = self._start()

    def _start(self) -> ServiceProcess:
        service = ServiceProcess(self.data, "--no-jobs", "--rig", str(self.rig_file), bench=self.server.url)
        self.follower = Follower(service.url, service.token)
        return service

    def kill(self, victim: str, moment: random.Random) -> float:
        """Seconds from the kill until the output is at 0 V and stays there."""
        lab, rig = self.service.client, self.service.rig
        campaign = lab.create_campaign(f"kill {victim}", rig)
        lease = lab.take_lease(rig, "killer", ttl_s=600)
        if lab.rig(rig).trip is not None:
            lab.reset_rig(rig, lease)
        run = lab.start_run(campaign.id, DRIVE, lease).id
        wait_until(lambda: any(e.run == run and e.kind == "block" for e in list(self.follower.events)))
        pids = lab.processes()
        time.sleep(moment.uniform(0, 3))
        pid = pids[{"rig": f"rig {rig}", "frozen": "api"}.get(victim, victim)]
        os.kill(pid, signal.SIGSTOP if victim == "frozen" else signal.SIGKILL)
        took = self._until_zero()
        if victim == "frozen":
            os.kill(pid, signal.SIGCONT)
        self.acknowledged |= self.follower.acknowledged
        if victim == "supervisor":
            self.service.close()
            self.service = self._start()
            lab = self.service.client
        else:
            lease.close()
        wait_until(lambda: lab.run(run).state in ENDED)
        lab.wait_until_idle(self.service.rig)
        return took

    def _until_zero(self) -> float:
        began = last = time.monotonic()
        while time.monotonic() - last < 0.5:
            if self.server.say("levels 0.01")[OUTPUT] != 0.0:
                last = time.monotonic()
            if time.monotonic() - began > 30:
                break
        return last - began


class Work:
    """Jobs of one kind in one campaign; each is another job to the service, since its band begins elsewhere."""

    def __init__(self, service: ServiceProcess, campaign: str, moment: random.Random) -> None:
        self.service, self.campaign, self.moment = service, campaign, moment
        # The first one waits for the worker's imports, and says nothing of the others.
        service.client.wait_for_job(self._order(), 300.0)
        self.latest_s = 3.0

    def kill(self, victim: str) -> float:
        """Seconds from the kill until a job that was computed at that moment is done."""
        lab = self.service.client
        while True:
            job = self._order()
            # One that was killed before is not there for a while.
            wait_until(lambda name=job: lab.job(name).state != "queued" and _pids(self.service, victim))
            time.sleep(self.moment.uniform(0, self.latest_s))
            pids = _pids(self.service, victim)
            if lab.job(job).state == "running" and pids:
                break
            # Done already: it takes less long than was thought.
            self.latest_s *= 0.8
        psutil.Process(self.moment.choice(pids)).kill()
        began = time.monotonic()
        done = lab.wait_for_job(job, 300.0)
        if done.state != "done":
            raise AssertionError(f"job {job} is {done.state}: {done.error}")
        return time.monotonic() - began

    def _order(self) -> str:
        low = self.moment.uniform(1.5, 2.5)
        return self.service.client.order_job(self.campaign, "identify", band_hz=[low, 400.0]).id


def _pids(service: ServiceProcess, victim: str) -> list[int]:
    return [pid for name, pid in service.client.processes().items() if name.startswith(victim)]


def wait_until(happened: Callable[[], object], patience_s: float = 120.0) -> None:
    deadline = time.monotonic() + patience_s
    while not happened():
        if time.monotonic() > deadline:
            raise TimeoutError(f"not within {patience_s} s")
        time.sleep(0.02)


def one_by_one(victim: str, kills: int, kill: Callable[[], float]) -> list[float]:
    """What every kill took, in s; each is printed as it comes, so that a run that is ended early is not for nothing."""
    took: list[float] = []
    for n in range(1, kills + 1):
        took.append(kill())
        print(f"{victim} {n} of {kills}: {took[-1]:.3f} s", flush=True)
    return took


def kill_drives(victim: str, kills: int, seed: int) -> int:
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    moment = random.Random(seed)
    with NiServer(rig, "9215", "--pace", virtual=False) as server, tempfile.TemporaryDirectory() as folder:
        server.say("preamplifiers sine")
        (Path(folder) / "rig.yaml").write_text(dump_rig(rig), encoding="utf-8")
        bench = Bench(server, Path(folder))
        try:
            took = one_by_one(victim, kills, lambda: bench.kill(victim, moment))
            require_kept(bench.service.client, bench.acknowledged)
        finally:
            bench.service.close()
    good = sum(t <= LIMIT_S[victim] for t in took)
    print(
        f"{victim}: {good} of {len(took)} at 0 V within {LIMIT_S[victim]} s of kill -9; median {np.median(took):.3f} s,"
        f" longest {max(took):.3f} s; {len(bench.acknowledged)} acknowledged blocks, all there with their CRC-32"
    )
    return 0 if good == len(took) else 1


def kill_jobs(victim: str, kills: int, seed: int) -> int:
    moment = random.Random(seed)
    with (
        tempfile.TemporaryDirectory() as folder,
        ServiceProcess(Path(folder) / "data", "--workers", "1") as service,
    ):
        lab = service.client
        campaign = lab.create_campaign("jobs", service.rig).id
        with lab.take_lease(service.rig, "killer") as lease:
            run = lab.start_run(campaign, HITS, lease).id
            list(lab.follow_run(run))
        work = Work(service, campaign, moment)
        took = one_by_one(victim, kills, lambda: work.kill(victim))
    print(
        f"{victim}: all of {len(took)} jobs done after kill -9; median {np.median(took):.1f} s, longest {max(took):.1f}"
    )
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--victim", choices=[*LIMIT_S, "jobs", "scheduler", "worker"], default="rig")
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    kill = kill_drives if arguments.victim in LIMIT_S else kill_jobs
    try:
        return kill(arguments.victim, arguments.kills, arguments.seed)
    except httpx.HTTPError as error:
        print(f"the service did not answer: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
