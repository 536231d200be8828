"""A whole impact test on many channels at a high rate, with all on: limits, rest, storage, live samples and FRFs.

The service runs as its users start it. Its bench is a device of this file that gives 64 channels at 51.2 kHz in real
time, has a buffer of four seconds, and says so when it ran over. It hits as soon as it is asked to. Watched from
outside: samples that were lost, processor time of the rig's process, and how long after a block's last sample was taken
its event and its FRF were there. `--load` starts so many processes that never rest.

    python benchmarks/many_channels.py --seconds 60
    python benchmarks/many_channels.py --channels 11 --rate 2000 --load 25
"""

import argparse
import json
import multiprocessing
import os
import struct
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import yaml
from websockets.sync.client import connect

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from service_process import ServiceProcess

from modallab.bench.protocol import AcquisitionRequest, BenchInfo, Burst, DeliveredSampling, SampleChunk
from modallab.core.documents.runs import StopRun
from modallab.core.errors import BenchTimeoutError, SamplesLostError, UnsupportedError
from modallab.core.plan import HitAcceptance, ImpactPlan
from modallab.core.rig import Rig
from modallab.storage import Store

ENDED = ("done", "failed", "aborted")
ENTRY = "[modallab.backends]\nmany = many_channels:open_many\n"
BUFFER_S = 4.0
RING_S = 4.0
NOISE_V = 1e-5


@dataclass(eq=False, slots=True)
class ManyChannels:
    """A device of many channels in real time: noise, and a hit with its ring-down when it is asked for."""

    url: str
    rig: Rig
    rate_hz: float = 0.0
    _next: int = 0
    _hit: int = -1
    _began_s: float = 0.0
    _noise: Any = None
    _ring: Any = None
    info: BenchInfo = field(init=False)

    def __post_init__(self) -> None:
        self.info = BenchInfo(self.url, (("many", "1"),), False, True, {})

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        self.rate_hz = request.rate_hz
        channels, rng = len(self.rig.channels), np.random.default_rng(1)
        self._noise = (NOISE_V * rng.standard_normal((channels, round(self.rate_hz)))).astype(np.float32)
        self._ring = _response(channels, self.rate_hz, rng)
        units = ("V",) * channels
        rate = self.rate_hz
        return DeliveredSampling(rate, rate, rate, np.dtype(np.float32), np.ones(channels), units)

    def start(self) -> None:
        self._next, self._hit, self._began_s = 0, -1, time.monotonic()
        Path(os.environ["MANY_BEGAN"]).write_text(str(self._began_s))

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        due_s = self._began_s + (self._next + count) / self.rate_hz
        wait_s = due_s - time.monotonic()
        if wait_s > timeout_s:
            raise BenchTimeoutError(f"{wait_s:.1f} s to wait")
        if wait_s < -BUFFER_S:
            raise SamplesLostError(f"the buffer of {BUFFER_S:g} s ran over")
        time.sleep(max(0.0, wait_s))
        places = np.arange(self._next, self._next + count)
        samples = self._noise[:, places % self._noise.shape[1]]
        self._add(samples)
        chunk = SampleChunk(self._next, samples, np.zeros(len(samples), np.bool_))
        self._next += count
        return chunk

    def _add(self, samples: Any) -> None:
        since = self._next - self._hit
        part = self._ring[:, max(0, since) : max(0, since + samples.shape[1])]
        if self._hit >= 0 and part.size:
            begin = max(0, -since)
            samples[:, begin : begin + part.shape[1]] += part

    def play(self, burst: Burst) -> int:
        raise UnsupportedError("there is no output")

    def prompt_hit(self, point: int) -> None:
        self._hit = self._next + round(0.2 * self.rate_hz)

    def zero(self) -> None: ...

    def stop(self) -> None: ...

    def close(self) -> None: ...


def _response(channels: int, rate_hz: float, rng: np.random.Generator) -> Any:
    """(channels, n) V: a half sine of 1 ms, and twelve modes that have died out at the end."""
    t = np.arange(round(RING_S * rate_hz)) / rate_hz
    found = np.zeros((channels, t.size), np.float32)
    pulse = t < 1e-3
    found[0, pulse] = 0.1 * np.sin(np.pi * t[pulse] / 1e-3)
    for f in np.geomspace(30, 0.15 * rate_hz, 12):
        shape = rng.standard_normal(channels - 1)
        found[1:] += (0.01 * shape[:, None] * np.exp(-4 * t) * np.sin(2 * np.pi * f * t)).astype(np.float32)
    return found


def open_many(url: str, rig: Rig) -> ManyChannels:
    """For the entry point."""
    return ManyChannels(url, rig)


def rig_file(folder: Path, channels: int) -> Path:
    force = {"index": 0, "name": "force", "quantity": "force", "unit": "N", "sensitivity_v_per_unit": 0.001}
    rest = [
        {"index": n, "name": f"a{n:02d}", "quantity": "acceleration", "unit": "m/s^2", "point": 1,
         "sensitivity_v_per_unit": 0.01}
        for n in range(1, channels)
    ]  # fmt: skip
    rig = {
        "name": "many",
        "model": "unknown",
        "bench": "many://one",
        "points": [{"id": 1, "x_m": 0.1}],
        "channels": [force, *rest],
        "converter": {"bits": 24, "range_v": 10.0, "noise_rms_v": NOISE_V},
    }
    path = folder / "rig.yaml"
    path.write_text(yaml.safe_dump(rig))
    return path


@dataclass(slots=True)
class Watched:
    """What a viewer saw of one run."""

    samples: int = 0
    lost: int = 0
    frfs: list[tuple[int, float]] = field(default_factory=list[tuple[int, float]])
    """(averages, when it was there by the monotonic clock)."""
    events: list[float] = field(default_factory=list[float])
    """When each accepted block's event was there."""


def parse(message: bytes | str) -> dict[str, Any]:
    assert isinstance(message, bytes)
    (length,) = struct.unpack("<I", message[:4])
    return json.loads(message[4 : 4 + length])


def watch_samples(service: ServiceProcess, run: str, seen: Watched) -> None:
    with open_socket(service, f"/live?run={run}&after=0") as socket:
        while not (about := parse(socket.recv(60.0)))["ended"]:
            seen.samples += about["shape"][1]
            seen.lost += about["lost"]


def watch_frfs(service: ServiceProcess, run: str, seen: Watched, until: threading.Event, outputs: int) -> None:
    chosen = "&".join(f"output=a{n:02d}" for n in range(1, outputs + 1))
    with open_socket(service, f"/runs/{run}/frf/live?{chosen}") as socket:
        while not until.is_set():
            try:
                about = parse(socket.recv(1.0))
            except TimeoutError:
                continue
            seen.frfs.append((about["averages"], time.monotonic()))


def watch_events(service: ServiceProcess, run: str, seen: Watched) -> None:
    for event in service.client.follow_run(run):
        if event.kind == "block" and event.content["accepted"]:
            seen.events.append(time.monotonic())


def never_rest() -> None:
    while True:
        pass


def in_ms(late: list[float]) -> str:
    chosen = late if len(late) < 40 else [late[len(late) // 2], *late[-5:]]
    return f"{len(late)}: " + ", ".join(f"{1e3 * x:.0f}" for x in chosen)


def open_socket(service: ServiceProcess, path: str) -> Any:
    address = service.url.replace("http", "ws") + "/api/v1" + path
    return connect(address, additional_headers={"Authorization": f"Bearer {service.token}"}, max_size=None)


def busy_s(pid: int) -> float:
    times = psutil.Process(pid).cpu_times()
    return times.user + times.system


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--channels", type=int, default=64)
    parser.add_argument("--rate", type=float, default=51200.0)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--outputs", type=int, default=2, help="FRFs watched live")
    parser.add_argument("--load", type=int, default=0)
    arguments = parser.parse_args()
    busy = [multiprocessing.Process(target=never_rest, daemon=True) for _ in range(arguments.load)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        entry = folder / "many_channels-0.dist-info"
        entry.mkdir()
        (entry / "METADATA").write_text("Metadata-Version: 2.1\nName: many_channels\nVersion: 0\n")
        (entry / "entry_points.txt").write_text(ENTRY)
        env = {"PYTHONPATH": os.pathsep.join((name, str(Path(__file__).parent))), "MANY_BEGAN": str(folder / "began")}
        rig = rig_file(folder, arguments.channels)
        with ServiceProcess(folder / "data", "--rig", str(rig), "--no-jobs", env=env) as service:
            for process in busy:
                process.start()
            try:
                return measure(service, arguments, folder)
            finally:
                for process in busy:
                    process.terminate()


def measure(service: ServiceProcess, arguments: argparse.Namespace, folder: Path) -> int:
    lab = service.client
    campaign = lab.create_campaign("many", service.rig)
    lease = lab.take_lease(service.rig, "Ada", ttl_s=3600)
    plan = ImpactPlan(points=(1,), hits=1000, rate_hz=arguments.rate, acceptance=HitAcceptance(max_force_n=490.0))
    run = lab.start_run(campaign.id, plan, lease).id
    while (view := lab.run(run)).state not in ("acquiring", "armed"):
        if view.state in ENDED:
            raise SystemExit(f"run {view.state}: {view.reason}")
        time.sleep(0.05)
    seen, until = Watched(), threading.Event()
    viewers = [
        threading.Thread(target=watch_samples, args=(service, run, seen), daemon=True),
        threading.Thread(target=watch_events, args=(service, run, seen), daemon=True),
        threading.Thread(target=watch_frfs, args=(service, run, seen, until, arguments.outputs), daemon=True),
    ]
    for viewer in viewers:
        viewer.start()
    pids = lab.processes()
    before, began_s = {name: busy_s(pid) for name, pid in pids.items()}, time.monotonic()
    time.sleep(arguments.seconds)
    took = time.monotonic() - began_s
    shares = {name: (busy_s(pid) - before[name]) / took for name, pid in pids.items()}
    if lab.run(run).state not in ENDED:
        lab.command_run(run, StopRun(), lease)
    while lab.run(run).state not in ENDED:
        time.sleep(0.1)
    until.set()
    for viewer in viewers:
        viewer.join(30)
    view = lab.run(run)
    blocks = [b for b in lab.blocks(run) if b.accepted]
    start_s = float((folder / "began").read_text())
    ends = [start_s + (b.first_sample + b.count) / arguments.rate for b in blocks]
    late = sorted(at - ends[n - 1] for n, at in seen.frfs if n <= len(ends) and n > 1)
    # The catalogue's clock is the machine's own, as is the device's here.
    with Store(folder / "data") as store:
        rows = [row for row in store.catalogue.blocks(run) if row.note.accepted]
    kept = sorted(row.monotonic_s - end for row, end in zip(rows, ends, strict=True))
    print(f"run {view.state}: {len(blocks)} of {view.blocks} blocks accepted; {view.reason}")
    print(f"live: {seen.samples} samples each, {seen.lost} lost")
    print("share of a core by process: " + ", ".join(f"{name} {share:.2f}" for name, share in shares.items()))
    events = sorted(at - end for at, end in zip(seen.events, ends, strict=False))
    for what, found in (("record", kept), ("event", events), ("FRF", late)):
        print(f"last sample of a block to its {what}, ms, of {in_ms(found)}")
    print(f"load {os.getloadavg()[0]:.0f} on {os.cpu_count()} cores")
    return int(seen.lost > 0 or view.state != "done")


if __name__ == "__main__":
    sys.exit(main())
