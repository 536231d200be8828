"""Records until a disk of 6 MB is full, then says what happened: python small_disk_child.py MOUNT.

Runs in a mount namespace of its own, so that it may mount, and so that nothing is left behind.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from modallab.bench.protocol import BenchInfo, DeliveredSampling
from modallab.core.errors import DiskFullError
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Channel, Rig
from modallab.storage import BlockNote, Store

N = 4096


def main(mount: Path) -> dict[str, object]:
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=6m", "none", str(mount)], check=True)
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [Channel(index=n, name=f"a{n:02}", quantity="acceleration", unit="m/s^2") for n in range(1, 11)]
    rig = Rig(name="small", model="unknown", channels=tuple(channels))
    # The plan is for few blocks, and then hits are rejected again and again: a run can need more than its plan says.
    plan = ImpactPlan(points=(1,), hits=5, block_s=N / 2000)
    kept: list[np.ndarray] = []
    rng = np.random.default_rng(6)
    with Store(mount / "data") as store:
        bench = BenchInfo("sim://somewhere", (), True, False, {})
        delivery = DeliveredSampling(2000.0, 2000.0, 2000.0, np.dtype("int32"), np.ones(11), ("V",) * 11)
        recorder = store.begin(plan, rig, bench)
        code = ""
        with recorder:
            recorder.open(delivery, N)
            recorder.enter_state("acquiring")
            try:
                while len(kept) < 100:
                    samples = rng.integers(-(2**31), 2**31, (11, N), dtype=np.int32)
                    recorder.record_block(samples, BlockNote(f"b{len(kept)}", "impact", N * len(kept)))
                    kept.append(samples)
            except DiskFullError as error:
                code = error.code
                recorder.enter_state("failed", "disk_full")
    with Store(mount / "data") as store:
        run = store.catalogue.run(recorder.run)
        back = store.blocks(recorder.run)
        equal = all(np.array_equal(block.samples, samples) for block, samples in zip(back, kept, strict=True))
        try:
            store.begin(plan, rig, bench).open(delivery, N)
            again = ""
        except DiskFullError as error:
            again = error.code
    state = [run.state, run.reason]
    return {"kept": len(kept), "equal": equal, "code": code, "state": state, "again": again}


if __name__ == "__main__":
    print(json.dumps(main(Path(sys.argv[1]))), flush=True)
    os._exit(0)
