"""A small rig, a delivery and a store to record into."""

import numpy as np

from modallab.bench.protocol import BenchInfo, DeliveredSampling
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Channel, Rig
from modallab.storage import Recorder, Store

N = 64
INFO = BenchInfo("sim://somewhere", (("box", "0042"),), True, False, {"seed": "7"})
PLAN = ImpactPlan(points=(1,), block_s=N / 2000)


def small_rig(name: str = "small") -> Rig:
    force = Channel(index=0, name="force", quantity="force", unit="N")
    response = Channel(index=1, name="a01", quantity="acceleration", unit="m/s^2")
    return Rig(name=name, model="unknown", channels=(force, response))


def delivery(dtype: str = "int16") -> DeliveredSampling:
    return DeliveredSampling(1000.0, 1651.6, 2000.0, np.dtype(dtype), np.array([1e-4, 2e-4]), ("V", "V"))


def begin(store: Store, *, rig: Rig | None = None, dtype: str = "int16", plan: ImpactPlan = PLAN) -> Recorder:
    recorder = store.begin(plan, rig or small_rig(), INFO)
    recorder.open(delivery(dtype), N)
    return recorder


def noise(seed: int, dtype: str = "int16", count: int = N) -> np.ndarray:
    rng = np.random.default_rng(seed)
    if np.dtype(dtype).kind == "f":
        return rng.normal(size=(2, count)).astype(dtype)
    info = np.iinfo(dtype)
    return rng.integers(info.min, info.max, (2, count), dtype=dtype, endpoint=True)
