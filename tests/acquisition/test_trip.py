"""The latch of the emergency stop: it outlives processes, rejects to arm, and says what tripped it."""

from pathlib import Path

import pytest
from scripted_bench import ScriptedBench, scripted_rig

from modallab.acquisition.process.rig_process import RigProcess
from modallab.acquisition.process.run import run_plan
from modallab.acquisition.process.trip import TripLatch, TrippedError
from modallab.core.events import Event
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.core.rig import Limits, Rig
from modallab.storage import Store

LIMITS = Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=50.0, acceleration_m_s2=60.0, max_burst_s=20.0)
SINE = SinePlan(frequencies_hz=(20.0, 60.0), settle_s=2.0, wait_s=1.0)
IMPACT = ImpactPlan(points=(1,), hits=2, block_s=0.256, hit_timeout_s=5.0)
URL = "sim://cantilever?seed=2&zeta=0.01"


def test_a_trip_stays_until_it_is_reset_and_the_first_cause_holds(tmp_path: Path) -> None:
    latch = TripLatch(tmp_path, "nidaqmx://cDAQ1")
    assert latch.read() is None
    latch.trip("emergency stop", "by the operator")
    latch.trip("time-out", "later")
    again = TripLatch(tmp_path, "nidaqmx://cDAQ1")
    assert again.is_tripped
    with pytest.raises(TrippedError, match=r"emergency stop at 20.*by the operator") as caught:
        again.require_reset()
    assert "reset" in caught.value.remedy
    found = again.reset()
    assert found is not None
    assert found.cause == "emergency stop"
    assert not latch.is_tripped
    latch.require_reset()
    assert latch.reset() is None


def test_it_belongs_to_the_output_whatever_the_addresss_options(tmp_path: Path) -> None:
    TripLatch(tmp_path, "nidaqmx+grpc://pc:1/cDAQ1?tls=a.crt").trip("emergency stop", "x")
    assert TripLatch(tmp_path, "nidaqmx+grpc://pc:1/cDAQ1").is_tripped
    assert not TripLatch(tmp_path, "nidaqmx+grpc://pc:1/cDAQ2").is_tripped


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"url": "x"}', "\x00"])
def test_a_latch_that_cannot_be_read_is_a_tripped_one(tmp_path: Path, damage: str) -> None:
    latch = TripLatch(tmp_path, "nidaqmx://cDAQ1")
    latch.trip("death", "x")
    (file,) = (tmp_path / "trips").iterdir()
    file.write_text(damage)
    with pytest.raises(TrippedError, match="unreadable"):
        latch.require_reset()
    latch.reset()
    latch.require_reset()


@pytest.mark.parametrize("plan", [IMPACT, SINE], ids=["impact", "sine"])
def test_nothing_is_armed_while_it_is_tripped(store: Store, tmp_path: Path, plan: Plan) -> None:
    bench, events = ScriptedBench(), list[Event]()
    latch = TripLatch(tmp_path, "scripted://")
    latch.trip("emergency stop", "x")
    with store.begin(plan, scripted_rig(LIMITS), bench.info) as recorder, pytest.raises(TrippedError):
        run_plan(bench, scripted_rig(LIMITS), plan, recorder, events.append, latch=latch)
    assert "armed" not in [e.state for e in events if e.kind == "state"]
    assert "play" not in bench.done
    assert not bench.prompts
    failed = events[-1]
    assert failed.kind == "failed"
    assert failed.code == "tripped"


@pytest.mark.parametrize(("cause", "state"), [("emergency stop", "aborted"), ("time-out", "failed")])
def test_a_run_ends_when_somebody_else_trips_the_rig(store: Store, tmp_path: Path, cause: str, state: str) -> None:
    bench, events = ScriptedBench(), list[Event]()
    latch = TripLatch(tmp_path, "scripted://")

    def control() -> None:
        if bench.done.count("play") == 2:
            latch.trip("time-out" if cause == "time-out" else "emergency stop", "x")

    rig = scripted_rig(LIMITS)
    with store.begin(SINE, rig, bench.info) as recorder:
        if state == "failed":
            with pytest.raises(TrippedError):
                run_plan(bench, rig, SINE, recorder, events.append, control, latch=latch)
        else:
            run_plan(bench, rig, SINE, recorder, events.append, control, latch=latch)
    found = store.catalogue.run(recorder.run)
    assert (found.state, found.valid) == (state, state == "failed")
    assert bench.done[-2:] == ["zero", "stop"]
    assert len(store.blocks(recorder.run)) == 1


def test_the_emergency_stop_latches_over_the_processs_end(link_rig: Rig, tmp_path: Path) -> None:
    with RigProcess(URL, link_rig, tmp_path) as process:
        for event in process.run(ImpactPlan(points=(10,), hits=500)):
            if event.kind == "block" and event.n == 0:
                process.emergency_stop("somebody shouted")
        assert process.view.state == "aborted"
    with RigProcess(URL, link_rig, tmp_path) as process:
        with pytest.raises(TrippedError, match="somebody shouted"):
            list(process.run(SINE))
        trip = process.latch.reset()
        assert trip is not None
        assert trip.what == "somebody shouted"
        assert process.trip is None
        list(process.run(SINE))
        assert process.view.state == "done"
    with Store(tmp_path) as store:
        first, second, third = store.catalogue.runs()
    assert (first.state, first.valid, first.reason) == ("aborted", False, "emergency stop")
    assert second.state == "failed"
    assert third.state == "done"


def test_an_emergency_stop_without_a_run_latches_too(link_rig: Rig, tmp_path: Path) -> None:
    with RigProcess(URL, link_rig, tmp_path) as process:
        _ = process.info
        process.emergency_stop()
        with pytest.raises(TrippedError):
            list(process.run(SINE))


def test_a_latch_of_an_earlier_version_is_read(tmp_path: Path) -> None:
    latch = TripLatch(tmp_path, "sim://cantilever")
    latch.trip("time-out", "no sign of life for 1 s")
    (path,) = (tmp_path / "trips").iterdir()
    renamed = '"silence"'
    path.write_text(path.read_text("utf-8").replace('"time-out"', renamed), "utf-8")
    found = latch.read()
    assert found is not None
    assert found.cause == "time-out"
