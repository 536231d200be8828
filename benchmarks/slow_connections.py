"""Idle and slow connections without a token, and how soon a request with the token is answered beside them.

A third of them send nothing, a third a head that never ends, a third a body that never ends; the slow ones send a byte
a second, and whoever is cut off comes again. Then requests with the token, each on a connection of its own, and the
emergency stop. Prints also what the service wrote into its log.

    python benchmarks/slow_connections.py --connections 2000
"""

import argparse
import multiprocessing
import selectors
import socket
import sys
import tempfile
import time
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
import numpy as np
import psutil

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from service_process import ServiceProcess

LIMIT_S = 1.0
HEADS = (
    b"",
    b"GET /api/v1/rigs HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: ",
    b"POST /api/v1/session HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 900\r\n\r\n",
)


def crowd(address: tuple[str, int], count: int, until: Any, held: Any) -> None:
    """Hold `count` connections; whoever was cut off begins again. A process of its own."""
    import resource

    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    look = selectors.DefaultSelector()
    kinds: dict[socket.socket, int] = {}
    while not until.is_set():
        began = time.monotonic()
        while len(kinds) < count and time.monotonic() - began < 1.0:
            kind = len(kinds) % 3
            one = socket.create_connection(address, 10)
            one.sendall(HEADS[kind])
            kinds[one] = kind
            look.register(one, selectors.EVENT_READ)
        held.value = len(kinds)
        for key, _ in look.select(0):
            one: Any = key.fileobj
            look.unregister(one)
            one.close()
            del kinds[one]
        for one, kind in list(kinds.items()):
            if kind:
                try:
                    one.send(b"x")
                except OSError:
                    continue
        until.wait(max(0.0, 1.0 - (time.monotonic() - began)))


def took(ask: Any) -> float:
    """Seconds until it was answered well."""
    began = time.monotonic()
    assert ask().status_code == 200
    return time.monotonic() - began


def used_s(process: psutil.Process) -> float:
    """Processor time."""
    times = process.cpu_times()
    return times.user + times.system


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connections", type=int, default=2000)
    parser.add_argument("--requests", type=int, default=100)
    arguments = parser.parse_args()
    spawn = multiprocessing.get_context("spawn")
    until, held = spawn.Event(), spawn.Value("i", 0)
    with tempfile.TemporaryDirectory() as folder, ServiceProcess(Path(folder) / "data", "--no-jobs") as service:
        place = urlsplit(service.url)
        asked = ((place.hostname, place.port), arguments.connections, until, held)
        process = spawn.Process(target=crowd, args=asked)
        rest = psutil.Process(service.client.processes()["api"])
        used = used_s(rest)
        process.start()
        end = time.monotonic() + 60
        while held.value < arguments.connections and time.monotonic() < end:
            time.sleep(0.1)
        most = held.value
        headers = {"Authorization": f"Bearer {service.token}"}
        times: list[float] = []
        first_s = 0.0
        for _ in range(arguments.requests):
            times.append(took(lambda: httpx.get(f"{service.url}/api/v1/rigs", headers=headers, timeout=30.0)))
            first_s = used_s(rest) - used if len(times) == 1 else first_s
            time.sleep(0.2)
        stop_s = took(lambda: httpx.post(service.stop_url, timeout=30.0))
        until.set()
        process.join(30)
        log = len(service.log)
    print(
        f"{most} idle and slow connections: {len(times)} requests with the token answered in {np.median(times):.3f} s"
        f" (median), {max(times):.3f} s (longest); processor time of the REST process until the first {first_s:.2f} s;"
        f" emergency stop {stop_s:.3f} s; log {log} bytes"
    )
    return 0 if max(times) <= LIMIT_S and most >= arguments.connections else 1


if __name__ == "__main__":
    sys.exit(main())
