"""A run in a store without a bench: what tests of rows and files need."""

import numpy as np

from modallab.bench.protocol import BenchInfo, DeliveredSampling
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Channel, Rig
from modallab.storage import BlockNote, Store

SAMPLES = 64


def record_run(store: Store, blocks: int) -> str:
    """Record an ended impact run of short noisy blocks; returns its name."""
    force = Channel(index=0, name="force", quantity="force", unit="N")
    response = Channel(index=1, name="a01", quantity="acceleration", unit="m/s^2")
    rig = Rig(name="small", model="unknown", channels=(force, response))
    plan = ImpactPlan(points=(1,), block_s=SAMPLES / 2000)
    noise = np.random.default_rng(1).integers(-999, 999, (blocks, 2, SAMPLES), dtype="int16")
    with store.begin(plan, rig, BenchInfo("sim://somewhere", (), True, False, {})) as recorder:
        recorder.open(
            DeliveredSampling(2000.0, 2000.0, 2000.0, np.dtype("int16"), np.array([1e-4, 2e-4]), ("V", "V")), SAMPLES
        )
        for n, samples in enumerate(noise):
            recorder.record_block(samples, BlockNote(f"b{n}", "impact", SAMPLES * n, 1))
        recorder.enter_state("done")
        return recorder.run
