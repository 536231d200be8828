"""Times how long it takes from the sample that is beyond a limit to 0 V, at the pace of the clock on the wall.

    python benchmarks/violation_latency.py --trials 100
    python benchmarks/violation_latency.py --trials 100 --load 20
    python benchmarks/violation_latency.py --trials 100 --load 20 --ordinary

The loop is the one that runs in a rig's process, at its priority; the simulated bench computes in the same process.
`--load` starts so many processes that never rest; `--ordinary` leaves the priority as it is. Counted are the time from
when the sample was due to when the output was set to 0 V, and the 4 ms in which the simulated amplifier follows.
"""

import argparse
import multiprocessing
import os
import tempfile
import time
from contextlib import suppress
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np

from modallab.acquisition.process.child import raise_priority
from modallab.acquisition.process.run import run_plan
from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Bench, BenchInfo, Burst, DeliveredSampling, SampleChunk
from modallab.core.errors import SafetyError
from modallab.core.plan import SinePlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig
from modallab.storage import Store

AMPLIFIER_S = 0.004
PLAN = SinePlan(
    frequencies_hz=(60.0,), levels_v={"low": 0.2}, block_s=0.128, ramp_s=0.1, settle_s=1.2, wait_s=0.1,
    settle_timeout_s=0.2,
)  # fmt: skip


class Spiking:
    """Passes everything on to a bench; an acceleration beyond its limit comes at a random sample of the burst."""

    def __init__(self, bench: Bench, rng: np.random.Generator) -> None:
        self.took_s = float("nan")
        self._bench, self._rng = bench, rng
        self._began_s = self._rate_hz = 0.0
        self._at: int | None = None

    @property
    def info(self) -> BenchInfo:
        return self._bench.info

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        delivery = self._bench.configure(request)
        self._rate_hz = delivery.rate_hz
        return delivery

    def start(self) -> None:
        self._bench.start()
        self._began_s = time.monotonic()

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        chunk = self._bench.read(count, timeout_s)
        if self._at is None or not chunk.first_sample <= self._at < chunk.first_sample + count:
            return chunk
        samples = chunk.samples.copy()
        samples[-1, self._at - chunk.first_sample] = 32000
        return replace(chunk, samples=samples)

    def play(self, burst: Burst) -> int:
        start = self._bench.play(burst)
        self._at = start + int(self._rng.uniform(0.3, 1.2) * self._rate_hz)
        return start

    def zero(self) -> None:
        self._bench.zero()
        if self._at is not None and np.isnan(self.took_s):
            self.took_s = time.monotonic() - self._began_s - self._at / self._rate_hz + AMPLIFIER_S

    def prompt_hit(self, point: int) -> None:
        self._bench.prompt_hit(point)

    def stop(self) -> None:
        self._bench.stop()

    def close(self) -> None:
        self._bench.close()


def trial(rig: Rig, seed: int) -> float:
    bench = Spiking(open_bench(f"sim://cantilever?seed={seed}&pace=1", rig), np.random.default_rng(seed))
    with (
        tempfile.TemporaryDirectory() as folder,
        Store(Path(folder)) as store,
        store.begin(PLAN, rig, bench.info) as recorder,
        suppress(SafetyError),
    ):
        run_plan(bench, rig, PLAN, recorder, lambda _: None)
    return bench.took_s


def never_rest() -> None:
    while True:
        pass


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--load", type=int, default=0)
    parser.add_argument("--ordinary", action="store_true")
    arguments = parser.parse_args()
    rig = parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "link_rig.yaml")
    trial(rig, 0)
    busy = [multiprocessing.Process(target=never_rest, daemon=True) for _ in range(arguments.load)]
    for process in busy:
        process.start()
    try:
        said = "ordinary priority" if arguments.ordinary else raise_priority() or "raised priority"
        took = np.array([trial(rig, seed) for seed in range(1, arguments.trials + 1)])
    finally:
        for process in busy:
            process.kill()
    load = f"{arguments.load} busy processes, load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors"
    print(f"{said}, {load}, {took.size} trials")
    print(f"median {np.median(took):.3f} s, p99 {np.quantile(took, 0.99):.3f} s, longest {took.max():.3f} s")


if __name__ == "__main__":
    main()
