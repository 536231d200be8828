"""How long the service takes from its command until every rig can be used, and from SIGTERM until it is gone.

Beside the time on the clock stands the processor time of all its processes up to then: on a machine that does other
work only that says something of the program.

    python benchmarks/start_and_stop.py --times 10
"""

import argparse
import statistics
import sys
import tempfile
import time
from pathlib import Path

import httpx
import psutil

from kill_anything import Service

START_S, STOP_S = 5.0, 3.0
PATIENCE_S = 300.0


def used_s(tree: list[psutil.Process]) -> float:
    """Processor time of those that live."""
    total = 0.0
    for process in tree:
        try:
            times = process.cpu_times()
        except psutil.Error:
            continue
        total += times.user + times.system
    return total


def once(service: Service) -> tuple[float, float, float, float]:
    """Seconds until the REST service answers, until it is good, processor time by then, seconds until it is gone."""
    began = time.monotonic()
    service.start()
    answered = 0.0
    while True:
        try:
            health = httpx.get(f"http://127.0.0.1:{service.port}/health", timeout=10).json()
        except httpx.HTTPError:
            health = {"status": ""}
        now = time.monotonic() - began
        answered = answered or (now if health["status"] else 0.0)
        if health["status"] == "good":
            break
        assert now < PATIENCE_S, "it does not become good"
        time.sleep(0.02)
    good, used = time.monotonic() - began, used_s(service.tree())
    # Jobs' processes may still start: to stop then is the harder case, and the more frequent one.
    assert service.process is not None
    asked = time.monotonic()
    service.process.terminate()
    assert service.process.wait(60) == 0
    return answered, good, used, time.monotonic() - asked


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", type=int, default=10)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        service = Service(Path(folder))
        found = [once(service) for _ in range(arguments.times)]
    load = psutil.getloadavg()[0] / psutil.cpu_count()
    names = ("answers", "good", "processor time until good", "gone after SIGTERM")
    for name, values in zip(names, zip(*found, strict=True), strict=True):
        print(f"{name}: {statistics.median(values):.2f} s (median), {max(values):.2f} s (longest)")
    print(f"{arguments.times} times; {load:.1f} times more work than processors")
    return 0 if all(good <= START_S and gone <= STOP_S for _, good, _, gone in found) else 1


if __name__ == "__main__":
    sys.exit(main())
