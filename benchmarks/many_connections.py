"""A thousand listeners beside a live run: nothing is lost, and the emergency stop does not queue behind them.

Opens connections that follow the events, while the simulated bench
runs an impact test in real time. Then it presses the emergency stop. The lateness of the acquisition's loop is taken
from the device's own count: how late each live frame arrived against the clock, less the earliest. The listeners are a
process of their own, so that what they cost themselves is not taken for lateness.

    python benchmarks/many_connections.py --connections 1000
"""

import argparse
import asyncio
import json
import multiprocessing
import struct
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from websockets.sync.client import connect

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from kept import Follower, require_kept
from service_process import ServiceProcess

from modallab.core.plan import ImpactPlan

BENCH = "sim://cantilever?seed=1&zeta=0.15&bad_hits=0&pace=1&reaction_s=0.2,0.4"
PLAN = ImpactPlan(points=(10, 6, 3), hits=100)


def crowd_of(url: str, token: str, count: int, until: Any, open_now: Any) -> None:
    """Hold `count` connections that follow the events; a process of its own."""
    asyncio.run(_listen(url, token, count, until, open_now))


async def _listen(url: str, token: str, count: int, until: Any, open_now: Any) -> None:
    headers = {"Authorization": f"Bearer {token}"}
    limits = httpx.Limits(max_connections=None)
    async with httpx.AsyncClient(base_url=url, headers=headers, limits=limits, timeout=None) as client:

        async def one() -> None:
            async with client.stream("GET", "/api/v1/events/stream") as response:
                open_now.value += 1
                async for _ in response.aiter_raw():
                    if until.is_set():
                        return

        tasks = [asyncio.create_task(one()) for _ in range(count)]
        while not until.is_set():
            await asyncio.sleep(0.2)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def lateness_ms(service: ServiceProcess, until: threading.Event, found: list[float]) -> None:
    """When each live frame was there, against when its last sample was taken."""
    address = service.url.replace("http", "ws") + "/api/v1/live"
    with connect(address, additional_headers={"Authorization": f"Bearer {service.token}"}, max_size=None) as socket:
        while not until.is_set():
            message = socket.recv(30.0)
            assert isinstance(message, bytes)
            (length,) = struct.unpack("<I", message[:4])
            about = json.loads(message[4 : 4 + length])
            last = about["first_sample"] + about["shape"][1]
            found.append(1e3 * (time.monotonic() - last / about["rate_hz"]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connections", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=30.0)
    arguments = parser.parse_args()
    spawn = multiprocessing.get_context("spawn")
    until, open_now, late = threading.Event(), spawn.Value("i", 0), list[float]()
    leave = spawn.Event()
    with (
        tempfile.TemporaryDirectory() as folder,
        ServiceProcess(Path(folder) / "data", "--no-jobs", bench=BENCH) as service,
    ):
        lab = service.client
        follower = Follower(service.url, service.token)
        campaign = lab.create_campaign("many", service.rig)
        lease = lab.take_lease(service.rig, "Ada", ttl_s=3600)
        asked = (service.url, service.token, arguments.connections, leave, open_now)
        crowd = spawn.Process(target=crowd_of, args=asked)
        crowd.start()
        while open_now.value < arguments.connections:
            time.sleep(0.1)
        run = lab.start_run(campaign.id, PLAN, lease).id
        viewer = threading.Thread(target=lateness_ms, args=(service, until, late), daemon=True)
        viewer.start()
        time.sleep(arguments.seconds)
        began = time.monotonic()
        assert httpx.post(service.stop_url, timeout=30.0).status_code == 200
        stop_ms = 1e3 * (time.monotonic() - began)
        until.set()
        leave.set()
        crowd.join(30)
        while lab.run(run).state not in ("aborted", "failed"):
            time.sleep(0.1)
        require_kept(lab, follower.acknowledged)
        seqs = [event.seq for event in follower.events]
    whole = seqs == list(range(1, len(seqs) + 1))
    delay = np.array(late) - min(late)
    p99 = float(np.percentile(delay, 99))
    print(
        f"{arguments.connections} connections: {len(follower.acknowledged)} acknowledged blocks, all there;"
        f" {len(seqs)} events, {'none' if whole else 'some'} missing; emergency stop {stop_ms:.0f} ms;"
        f" frames late by {np.median(delay):.1f} ms (median), {p99:.1f} ms (p99, with the way to the viewer)"
    )
    return 0 if whole and stop_ms < 200 else 1


if __name__ == "__main__":
    sys.exit(main())
