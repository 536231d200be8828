"""The emergency stop of a rig that drives: behind a proxy, on a full disk, without a database, with a frozen process.

The bench is the simulated NI device server, a process of its own in real time, so that its output is seen from outside.
In each case a sine test drives; then the stop is pressed again and again, each press on a connection of its own. Every
answer must be 200, and the output at 0 V with the first and from then on. The data folder is on a small disk of its
own, the catalogue on a PostgreSQL server of its own; needs the right to mount.

    python benchmarks/emergency_stop.py --presses 200
"""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from http.client import HTTPConnection
from importlib.resources import files
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from ni_server import NiServer
from postgresql_server import Server, postgresql_server
from service_process import ServiceProcess

from modallab.core.plan import SinePlan
from modallab.formats.rig.rig_file import dump_rig, parse_rig

OUTPUT = "cDAQ1Mod4/ao0"
DRIVE = SinePlan(
    frequencies_hz=tuple(19.0 + n / 4 for n in range(40)), settle_s=1.2, ramp_s=0.3, block_s=0.256, wait_s=0.2
)
PROXY = {"Host": "lab.example", "Origin": "https://lab.example", "X-Forwarded-Host": "lab.example"}
REWRITTEN = {"Origin": "https://lab.example", "X-Forwarded-Host": "lab.example"}
LIMIT_MS = 100.0
ZERO_S = 0.5


class Bench:
    """The service on the device server, with a run that drives."""

    def __init__(self, server: NiServer, service: ServiceProcess) -> None:
        self.server, self.service = server, service
        self.campaign = service.client.create_campaign("stops", service.rig).id

    def drive(self) -> None:
        lab, rig = self.service.client, self.service.rig
        lab.wait_until_idle(rig)
        self.lease = lab.take_lease(rig, "presser", ttl_s=600, take_over=True)
        if lab.rig(rig).trip is not None:
            lab.reset_rig(rig, self.lease)
        lab.start_run(self.campaign, DRIVE, self.lease)
        end = time.monotonic() + 60
        while self.level() == 0.0:
            assert time.monotonic() < end, "nothing is driven"

    def level(self, over_s: float = 0.02) -> float:
        return float(self.server.say(f"levels {over_s}")[OUTPUT])

    def press(self, headers: dict[str, str]) -> tuple[int, float]:
        began = time.monotonic()
        status = 0
        place = urlsplit(self.service.stop_url)
        connection = HTTPConnection(place.hostname or "", place.port, timeout=30.0)
        with suppress(OSError), closing(connection):
            connection.request("POST", place.path, headers=headers)
            answer = connection.getresponse()
            answer.read()
            status = answer.status
        return status, 1e3 * (time.monotonic() - began)

    def until_zero(self) -> float:
        """Seconds until the output is at 0 V, and stays there for half a second."""
        began = last = time.monotonic()
        while time.monotonic() - last < 0.5 and time.monotonic() - began < 30.0:
            if self.level() != 0.0:
                last = time.monotonic()
        return last - began


@contextmanager
def frozen(bench: Bench) -> Iterator[None]:
    """The rig's process is stopped as a debugger would."""
    pid = bench.service.client.processes()[f"rig {bench.service.rig}"]
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


@contextmanager
def full_disk(folder: Path) -> Iterator[None]:
    """Not a byte is free."""
    other = folder / "other"
    with other.open("wb", buffering=0) as file, suppress(OSError):
        while file.write(bytes(min(1 << 16, max(1, shutil.disk_usage(folder).free)))):
            pass
    try:
        yield
    finally:
        other.unlink()


@contextmanager
def no_database(server: Server) -> Iterator[None]:
    """The database's server is stopped."""
    server.stop()
    try:
        yield
    finally:
        server.start()


@contextmanager
def nothing() -> Iterator[None]:
    """All is well."""
    yield


def measure(name: str, bench: Bench, fault: Callable[[], object], headers: dict[str, str], presses: int) -> bool:
    """Whether every press was answered with 200 and the output stayed at 0 V."""
    bench.drive()
    with fault():  # type: ignore[attr-defined]
        pressed = [bench.press(headers)]
        zero_s = bench.until_zero()
        pressed += [bench.press(headers) for _ in range(presses - 1)]
        zero = bench.level() == 0.0
    took = [ms for _, ms in pressed]
    good = sum(status == 200 for status, _ in pressed)
    p99 = float(np.percentile(took, 99))
    stays = "" if zero else " AND NOT TO THE END"
    print(
        f"{name}: {good} of {presses} answered with 200, output at 0 V {zero_s:.2f} s after the first{stays}; first"
        f" {took[0]:.0f} ms, median {np.median(took):.1f} ms, p99 {p99:.1f} ms, longest {max(took):.0f} ms",
        flush=True,
    )
    return good == presses and zero and zero_s <= ZERO_S and p99 <= LIMIT_MS


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--presses", type=int, default=200)
    arguments = parser.parse_args()
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        disk = folder / "disk"
        disk.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256m", "tmpfs", str(disk)], check=True)
        stack.callback(subprocess.run, ["umount", "-l", str(disk)], check=True)
        server = stack.enter_context(NiServer(rig, "9215", "--pace", virtual=False))
        server.say("preamplifiers sine")
        database = stack.enter_context(postgresql_server())
        (folder / "rig.yaml").write_text(dump_rig(rig), encoding="utf-8")
        options = ("--no-jobs", "--rig", str(folder / "rig.yaml"))
        env = {"MODALLAB_DATABASE": database.new_database()}
        service = stack.enter_context(ServiceProcess(disk / "data", *options, bench=server.url, env=env))
        bench = Bench(server, service)
        cases: list[tuple[str, Callable[[], object], dict[str, str]]] = [
            ("nothing wrong", nothing, {}),
            ("behind a proxy", nothing, PROXY),
            ("behind a proxy that rewrites Host", nothing, REWRITTEN),
            ("full disk", lambda: full_disk(disk), {}),
            ("no database", lambda: no_database(database), {}),
            ("frozen rig", lambda: frozen(bench), {}),
        ]
        good = [measure(name, bench, fault, headers, arguments.presses) for name, fault, headers in cases]
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
