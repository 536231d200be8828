"""How many benches one data folder takes: blocks a second from N recorders at once, SQLite and PostgreSQL.

    PYTHONPATH=tests/helpers python benchmarks/many_benches.py [--seconds 5] [--benches 1 4 8] [--database sqlite]

Each recorder is a process, as on a bench, and records blocks of 1.024 s (11 channels, int32) without a pause. A bench
delivers 0.98 of them a second.
"""

import argparse
import multiprocessing as mp
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from postgresql_server import postgresql_server

from modallab.bench.protocol import BenchInfo, DeliveredSampling
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Channel, Rig
from modallab.storage import BlockNote, Store
from modallab.storage.engine import name_database

BLOCK_S = 1.024
CHANNELS = 11


def record(folder: Path, rate_hz: float, until: float, gate: Any) -> list[float]:
    """Times of each block, from its samples to its acknowledgement."""
    n = round(rate_hz * BLOCK_S)
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [Channel(index=k, name=f"a{k:02}", quantity="acceleration", unit="m/s^2") for k in range(1, CHANNELS)]
    rig = Rig(name="bench", model="unknown", channels=tuple(channels))
    delivery = DeliveredSampling(rate_hz, rate_hz, rate_hz, np.dtype("int32"), np.ones(CHANNELS), ("V",) * CHANNELS)
    samples = np.random.default_rng(1).integers(-(2**31), 2**31, (CHANNELS, n), dtype=np.int32)
    took: list[float] = []
    with (
        Store(folder) as store,
        store.begin(ImpactPlan(points=(1,)), rig, BenchInfo("sim://x", (), True, False, {})) as recorder,
    ):
        recorder.open(delivery, n)
        gate.wait()
        end = time.monotonic() + until
        while time.monotonic() < end:
            begun = time.monotonic()
            recorder.record_block(samples, BlockNote(f"b{len(took)}", "impact", 0))
            took.append(time.monotonic() - begun)
    return took


def _worker(folder: Path, rate_hz: float, until: float, gate: Any, out: Any) -> None:
    out.put(record(folder, rate_hz, until, gate))


def measure(folder: Path, benches: int, rate_hz: float, seconds: float) -> np.ndarray:
    with Store(folder):
        pass
    context = mp.get_context("spawn")
    gate, out = context.Barrier(benches), context.Queue()
    processes = [context.Process(target=_worker, args=(folder, rate_hz, seconds, gate, out)) for _ in range(benches)]
    for process in processes:
        process.start()
    took = [out.get() for _ in processes]
    for process in processes:
        process.join()
    return np.concatenate([np.array(t) for t in took])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--benches", type=int, nargs="+", default=[1, 4, 8])
    parser.add_argument("--database", choices=("sqlite", "postgresql"), nargs="+", default=["sqlite", "postgresql"])
    parser.add_argument("--rate", type=float, default=2000.0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as place, postgresql_server("on") as server:
        for kind in arguments.database:
            for benches in arguments.benches:
                folder = Path(place) / f"{kind}-{benches}"
                if kind == "postgresql":
                    name_database(folder, server.new_database())
                took = 1e3 * measure(folder, benches, arguments.rate, arguments.seconds)
                blocks = len(took) / arguments.seconds
                print(
                    f"{kind:<11} {benches:3} recorders: {blocks:7.1f} blocks/s, so {blocks * BLOCK_S:5.0f} benches; "
                    f"a block takes {np.median(took):6.1f} ms, p99 {np.quantile(took, 0.99):7.1f} ms",
                    flush=True,
                )


if __name__ == "__main__":
    main()
