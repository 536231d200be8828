"""The sine test: from rest, settled, within limits, and at 0 V however it ends."""

import numpy as np
import pytest
from scripted_bench import SCALE, ScriptedBench, Strike, burst_volts, scripted_rig

from modallab.acquisition.procedures.burst import burst_of
from modallab.acquisition.process.prepare_run import Order
from modallab.acquisition.process.run import record_run
from modallab.bench.protocol import Burst
from modallab.core.errors import DeviceGoneError, SafetyError
from modallab.core.events import Event
from modallab.core.plan import SinePlan
from modallab.core.rig import Limits
from modallab.storage import Store

LIMITS = Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=50.0, acceleration_m_s2=60.0, max_burst_s=20.0)
RIG = scripted_rig(LIMITS)
PLAN = SinePlan(frequencies_hz=(27.34375, 60.0), levels_v={"low": 0.5, "high": 2.0}, settle_s=2.0, wait_s=3.0)


def test_names_levels_and_frequencies_are_those_of_the_campaign_format(store: Store) -> None:
    run = record_run(ScriptedBench(), RIG, PLAN, store, lambda _: None)
    found = store.catalogue.blocks(run)
    assert [(r.note.name, r.note.level, r.note.frequency_hz, r.note.drive_point) for r in found] == [
        ("sine_low_027.344", "low", 27.34375, 2),
        ("sine_low_060.000", "low", 60.0, 2),
        ("sine_high_027.344", "high", 27.34375, 2),
        ("sine_high_060.000", "high", 60.0, 2),
    ]
    assert all(r.count == 1024 and r.note.facts["settled_before"] == "yes" for r in found)


def test_a_block_lies_in_the_settled_part_and_the_burst_has_ended_before_the_next(store: Store) -> None:
    bench = ScriptedBench()
    run = record_run(bench, RIG, PLAN, store, lambda _: None)
    starts = [int(r.note.facts["burst_first_sample"]) for r in store.catalogue.blocks(run)]
    for row, start in zip(store.catalogue.blocks(run), starts, strict=True):
        assert row.note.first_sample == start + 2000
    duration = burst_of(PLAN, 60.0, 1.0).duration_s
    assert np.diff(starts).min() >= (duration + PLAN.wait_s) * 1000
    block = store.blocks(run)[3]
    t = (PLAN.settle_s * 1000 + np.arange(1024)) / 1000
    expected = 100 * SCALE * 2.0 * np.sin(2 * np.pi * 60 * t)
    np.testing.assert_allclose(block.samples[0] * block.scale[0], expected, atol=6 * 2 * SCALE)


def test_the_burst_holds_over_the_whole_block_and_ends_at_exactly_zero() -> None:
    burst = burst_of(SinePlan(), 4.8828125, 0.5)
    t = np.arange(0, burst.duration_s, 1e-3)
    envelope = np.abs(burst_volts(Burst(0.25, 0.5, burst.ramp_s, burst.hold_s), t))
    assert burst.ramp_s + burst.hold_s >= SinePlan().settle_s + SinePlan().block_s
    assert envelope[-1] < 1e-5
    assert burst_volts(burst, np.array([0.0, burst.duration_s])).tolist() == [0.0, 0.0]


def tripped(store: Store, bench: ScriptedBench) -> tuple[list[Event], SafetyError]:
    events: list[Event] = []
    with pytest.raises(SafetyError) as caught:
        record_run(bench, RIG, PLAN, store, events.append)
    return events, caught.value


def test_beyond_a_limit_the_output_is_zeroed_at_once_and_all_blocks_are_kept(store: Store) -> None:
    # 100 counts per V are 1 N per V; 2600 are 13 N at the low level and 52 N at the high one, beyond 50 N.
    bench = ScriptedBench(gain=2600.0)
    events, error = tripped(store, bench)
    assert "force 5" in error.what
    assert "(limit 50)" in error.what
    assert "a01" not in error.what
    assert bench.done[-4:-2] == ["play", "zero"]
    (run,) = store.catalogue.runs()
    assert run.state == "failed"
    assert [b.name for b in store.blocks(run.id)] == ["sine_low_027.344", "sine_low_060.000"]
    last = store.catalogue.blocks(run.id)[-1]
    assert (last.note.name, last.note.accepted) == ("sine_high_027.344_tripped", False)
    assert last.note.reason == error.what
    assert [e.state for e in events if e.kind == "state"][-2:] == ["stopping", "failed"]
    failed = events[-1]
    assert failed.kind == "failed"
    assert failed.code == "safety"


def test_the_trip_comes_within_one_chunk_of_the_excess(store: Store) -> None:
    bench = ScriptedBench(gain=4000.0)
    tripped(store, bench)
    (run,) = store.catalogue.runs()
    last = store.blocks(run.id, rejected=True)[-1]
    out_of_band = np.flatnonzero(np.abs(last.samples[0] * last.scale[0]) > 50.0)
    assert out_of_band.size
    assert last.n_samples - out_of_band[0] <= 500


def test_a_limit_beyond_the_range_trips_at_the_end_of_the_range(store: Store) -> None:
    rig = scripted_rig(LIMITS.model_copy(update={"force_n": 1000.0, "acceleration_m_s2": 1000.0}))
    with pytest.raises(SafetyError, match=r"327\.7 N"):
        record_run(ScriptedBench(gain=20000.0), rig, PLAN, store, lambda _: None)


@pytest.mark.parametrize(("order", "state", "valid"), [("stop", "done", True), ("abort", "aborted", False)])
def test_ordered_to_end_in_a_burst_it_zeroes_first(store: Store, order: Order, state: str, valid: bool) -> None:
    bench = ScriptedBench()
    run = record_run(bench, RIG, PLAN, store, lambda _: None, lambda: order if bench.done.count("play") == 3 else None)
    assert bench.done[-3:] == ["play", "zero", "stop"]
    found = store.catalogue.run(run)
    assert (found.state, found.valid) == (state, valid)
    assert len(store.blocks(run)) == 2


def test_when_the_owner_is_lost_the_run_fails_with_its_blocks(store: Store) -> None:
    bench = ScriptedBench()
    run = record_run(bench, RIG, PLAN, store, lambda _: None, lambda: "lost" if bench.done.count("play") == 2 else None)
    assert bench.done[-3:] == ["play", "zero", "stop"]
    assert store.catalogue.run(run).state == "failed"
    assert "interrupted" in store.catalogue.run(run).reason


def test_an_error_of_any_kind_zeroes_the_output(store: Store) -> None:
    bench = ScriptedBench()

    def emit(event: Event) -> None:
        if event.kind == "block":
            raise ValueError("a listener that fails")

    with pytest.raises(ValueError, match="listener"):
        record_run(bench, RIG, PLAN, store, emit)
    assert bench.done[-2:] == ["zero", "stop"]
    assert store.catalogue.runs()[0].state == "failed"


class StubbornBench(ScriptedBench):
    """Cannot be zeroed any more."""

    def zero(self) -> None:
        super().zero()
        if self.position > 6000:
            raise DeviceGoneError("no answer", where="scripted://", remedy="plug it in")


def test_a_bench_that_cannot_be_zeroed_is_still_stopped_and_the_first_error_reported(store: Store) -> None:
    bench = StubbornBench(gone_at=12500)
    with pytest.raises(DeviceGoneError, match="the device is gone"):
        record_run(bench, RIG, PLAN, store, lambda _: None)
    assert bench.done[-2:] == ["zero", "stop"]


def knocked(store: Store, **fields: float) -> tuple[list[str], list[int]]:
    """Rest before every burst, and where the bursts began, when the table is knocked against before the second."""
    bench = ScriptedBench([Strike(peak_n=0.0, zeta=0.005)])

    def control() -> None:
        # Half a second before the second burst somebody knocks against the table.
        if bench.done.count("play") == 1 and not bench.prompts and bench.position > 31500:
            bench.prompt_hit(1)

    run = record_run(bench, RIG, PLAN.model_copy(update=fields), store, lambda _: None, control)
    assert bench.prompts
    found = store.catalogue.blocks(run)
    return (
        [str(r.note.facts["settled_before"]) for r in found],
        [int(r.note.facts["burst_first_sample"]) for r in found],
    )


def test_a_burst_waits_until_the_beam_is_at_rest(store: Store) -> None:
    notes, starts = knocked(store, wait_s=10.0, settle_timeout_s=60.0)
    assert notes == ["yes"] * 4
    # 60 Hz at 0.5 % takes longer than the rest of 10 s to fade from 30 m/s^2 to the noise.
    apart = np.diff(starts)
    assert apart[0] > apart[1] + 1000
    assert apart[1] == apart[2]


def test_past_the_patience_a_burst_begins_and_the_motion_is_noted(store: Store) -> None:
    notes, starts = knocked(store, wait_s=10.0, settle_timeout_s=0.1)
    assert notes == ["yes", "no", "yes", "yes"]
    assert len(set(np.diff(starts))) == 1


def test_lost_samples_repeat_the_step(store: Store) -> None:
    bench = ScriptedBench(lose_at=[13000])
    run = record_run(bench, RIG, PLAN, store, lambda _: None)
    assert len(store.blocks(run)) == 4
    assert bench.done.count("play") == 5
    assert "zero" in bench.done[bench.done.index("play") : -2]
