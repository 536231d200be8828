"""Limits of velocity, displacement and stroke from what accelerometers say, against the closed form of a sine."""

import numpy as np
import pytest
from scripted_bench import ScriptedBench, scripted_rig

from modallab.acquisition.monitor.motion_limits import MotionLimit, MotionWatch, motion_limits
from modallab.acquisition.process.run import record_run
from modallab.bench.protocol import Burst, SampleChunk
from modallab.core.errors import PlanError, SafetyError
from modallab.core.plan import SinePlan
from modallab.core.rig import Limits
from modallab.storage import Store

LIMITS = Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=50.0, acceleration_m_s2=60.0, max_burst_s=20.0)
RATE = 1000.0
REST = 500


def watch(integrations: int, limit: float, lowest_hz: float = 5.0) -> MotionWatch:
    return MotionWatch([MotionLimit(0, "it", "m", integrations, limit)], np.ones(1), RATE, lowest_hz)


def highest(found: MotionWatch, values: np.ndarray, chunk: int = 50) -> float:
    for first in range(0, values.size, chunk):
        found(SampleChunk(first, values[None, first : first + chunk], np.zeros(1, dtype=bool)))
    return found.share_of_limit


def burst(hz: float) -> np.ndarray:
    t = np.arange(4000) / RATE
    driven = 10.0 * np.sin(2 * np.pi * hz * t) * Burst(hz, 1.0, 1.0, 2.0).envelope(t)
    return np.concatenate([np.zeros(REST), driven])


@pytest.mark.parametrize("integrations", [1, 2])
@pytest.mark.parametrize("hz", [5.0, 30.0, 100.0])
def test_a_sine_has_the_velocity_and_the_displacement_of_the_closed_form(integrations: int, hz: float) -> None:
    found = watch(integrations, 1e9)
    reached = highest(found, burst(hz)) * 1e9
    assert reached == pytest.approx(10.0 / (2 * np.pi * hz) ** integrations, rel=0.04)


def test_an_offset_a_drift_and_the_start_add_up_to_nothing() -> None:
    t = np.arange(20_000) / RATE
    reached = highest(watch(2, 1e9), 9.81 + 0.01 * t) * 1e9
    # A ramp of 0.01 m/s^3 through the square of the filter comes to 0, by way of its transient.
    assert reached < 1e-3


def test_how_it_is_read_changes_nothing() -> None:
    values = burst(12.0)
    assert highest(watch(2, 1.0), values, 50) == pytest.approx(highest(watch(2, 1.0), values, 500), rel=1e-12)


def test_beyond_the_limit_it_says_what_and_how_much() -> None:
    with pytest.raises(SafetyError, match=r"it 0\.01\d* m \(limit 0\.01\)"):
        highest(watch(2, 0.01), burst(4.0))


def test_in_the_rise_it_is_foreseen_what_the_full_drive_will_do() -> None:
    found = watch(2, 0.008)
    found.begin(Burst(5.0, 1.0, 1.0, 2.0), REST)
    values = burst(5.0)
    with pytest.raises(SafetyError, match="will exceed the abort limit"):
        highest(found, values)
    assert found.share_of_limit < 0.6


def test_only_what_a_channel_does_not_measure_itself_is_integrated_and_the_stroke_only_at_the_shaker() -> None:
    limits = LIMITS.model_copy(update={"velocity_m_s": 1.0, "stroke_m": 0.01})
    found = [(limit.channel, limit.integrations, limit.limit) for limit in motion_limits(scripted_rig(limits), limits)]
    assert found == [(1, 1, 1.0), (2, 1, 1.0), (2, 2, 0.01)]


def test_a_stroke_is_held_before_the_level_is_raised(store: Store) -> None:
    # 1 m/s^2 at 5 Hz are 1.01 mm; 2 m/s^2 would be 2.03 mm.
    limits = LIMITS.model_copy(update={"stroke_m": 0.0015})
    plan = SinePlan(frequencies_hz=(5.0,), levels_v={"low": 1.0, "high": 2.0}, settle_s=2.0, wait_s=3.0)
    with pytest.raises(SafetyError, match=r"at the full drive, as predicted: stroke of a02 0\.00"):
        record_run(ScriptedBench(), scripted_rig(limits), plan, store, lambda _: None)
    run = store.catalogue.runs()[0]
    assert [row.note.name for row in store.catalogue.blocks(run.id)] == [
        "sine_low_005.000",
        "sine_high_005.000_tripped",
    ]


def test_a_stroke_that_no_channel_can_see_is_a_problem_of_the_plan(store: Store) -> None:
    rig = scripted_rig(LIMITS.model_copy(update={"stroke_m": 0.01}))
    rig = rig.model_copy(update={"channels": rig.channels[:2]})
    with pytest.raises(PlanError, match="stroke_m"):
        record_run(ScriptedBench(), rig, SinePlan(frequencies_hz=(5.0,)), store, lambda _: None)
