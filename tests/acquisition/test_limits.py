"""The abort limits: to the count, for every kind of sample."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scripted_bench import SCALE, scripted_rig

from modallab.acquisition.monitor.burst_watch import LimitWatch, limit_watch
from modallab.bench.protocol import DeliveredSampling, SampleChunk
from modallab.core.errors import SafetyError
from modallab.core.rig import Limits
from modallab.signals.conversion import Conversion

LIMITS = Limits(drive_v=1.0, slew_v_per_s=1.0, force_n=50.0, acceleration_m_s2=60.0, max_burst_s=1.0)


def watch(dtype: str = "int16") -> LimitWatch:
    scale = SCALE if dtype == "int16" else 1.0
    delivery = DeliveredSampling(1e3, 1e3, 1e3, np.dtype(dtype), np.full(3, scale), ("V", "V", "V"))
    return limit_watch(
        scripted_rig(LIMITS), LIMITS, Conversion.of(scripted_rig(), "sine", delivery.units, delivery.scale)
    )


def chunk(samples: np.ndarray) -> SampleChunk:
    return SampleChunk(0, samples, np.zeros(3, dtype=bool))


@given(st.lists(st.integers(-(2**15), 2**15 - 1), min_size=3, max_size=3))
def test_it_trips_exactly_beyond_the_limit(peaks: list[int]) -> None:
    samples = np.zeros((3, 20), dtype=np.int16)
    samples[:, 7] = peaks
    out_of_band = [
        name
        for name, peak, limit in zip(("force", "a01", "a02"), peaks, (5000, 6000, 6000), strict=True)
        if abs(peak) > limit
    ]
    if not out_of_band:
        watch()(chunk(samples))
        return
    with pytest.raises(SafetyError) as caught:
        watch()(chunk(samples))
    assert [name for name in ("force", "a01", "a02") if name in caught.value.what] == out_of_band


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_sample_that_is_no_number_is_beyond_every_limit(value: float) -> None:
    samples = np.zeros((3, 20), dtype=np.float32)
    watch("float32")(chunk(samples))
    samples[1, 3] = value
    with pytest.raises(SafetyError, match="a01"):
        watch("float32")(chunk(samples))
