"""The device's own reference trigger as an option of the impact test: the same hits, found by the device."""

from pathlib import Path

import numpy as np
import pytest
from ni_server import NiServer

from modallab.acquisition.monitor.run_states import OperatorRequests
from modallab.acquisition.process.run import record_run, run_plan
from modallab.bench.capabilities import ReferenceTrigger, TriggersInHardware
from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Bench
from modallab.core.errors import BenchTimeoutError, ConfigurationError, DeviceGoneError, PlanError
from modallab.core.events import Event
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.storage import Store

PLAN = ImpactPlan(points=(10,), hits=2, trigger="hardware", hit_timeout_s=60.0)


@pytest.fixture(scope="module")
def striking(rig: Rig):
    with NiServer(rig, "9215", "--bench", "sim://cantilever?seed=1&bad_hits=0&zeta=0.02") as server:
        server.say("preamplifiers impact")
        yield server


def operator(server: NiServer, events: list[Event]):
    def notify(event: Event) -> None:
        events.append(event)
        if event.kind == "hit_requested":
            server.say(f"strike {event.point}")

    return notify


def test_hits_are_found_by_the_device_with_the_pre_trigger_before_them(
    striking: NiServer, rig: Rig, tmp_path: Path
) -> None:
    events: list[Event] = []
    bench = open_bench(striking.url, rig)
    with Store(tmp_path) as store:
        run = record_run(bench, rig, PLAN, store, operator(striking, events))
        blocks, rows = store.blocks(run), store.catalogue.blocks(run)
    bench.close()
    assert [b.name for b in blocks] == ["impact_p10_1", "impact_p10_2"]
    sensitivity = rig.force_channel.sensitivity("impact")
    for block in blocks:
        assert block.n_samples == 2048
        force_n = block.samples[0] * block.scale[0] / sensitivity
        assert force_n[99] < PLAN.trigger_n <= force_n[100]
        assert np.abs(force_n[:99]).max() < PLAN.trigger_n
        assert force_n.max() > 10.0
    # The rest before a hit is judged from the record's own long pre-trigger.
    assert all(row.note.facts["residual_ratio"] == 0 for row in rows)
    states = [e.state for e in events if e.kind == "state"]
    assert states == ["created", "arming", "armed", "acquiring", "processing", "done"]


def test_with_a_pause_the_device_waits_no_longer_and_is_armed_again(
    striking: NiServer, rig: Rig, tmp_path: Path
) -> None:
    events: list[Event] = []
    requests = OperatorRequests()
    strike = operator(striking, events)

    def notify(event: Event) -> None:
        if event.kind == "hit_requested" and event.hit == 2 and not [e for e in events if e.kind == "notice"]:
            requested = [e for e in events if e.kind == "hit_requested" and e.hit == 2]
            if not requested:
                events.append(event)
                requests.pause()
                return
        strike(event)
        if event.kind == "state" and event.state == "paused":
            requests.resume()

    bench = open_bench(striking.url, rig)
    with Store(tmp_path) as store, store.begin(PLAN, rig, bench.info) as recorder:
        run_plan(bench, rig, PLAN, recorder, notify, requests=requests)
        assert len(store.blocks(recorder.run)) == 2
    bench.close()
    assert "paused" in [e.state for e in events if e.kind == "state"]


def test_a_bench_without_a_trigger_rejects_the_plan_naming_the_field(rig: Rig, tmp_path: Path) -> None:
    bench = open_bench("sim://cantilever?seed=1", rig)
    with Store(tmp_path) as store, pytest.raises(PlanError, match="trigger: hardware, but this bench"):
        record_run(bench, rig, PLAN, store, lambda _: None)


def armed(bench: Bench, rig: Rig, level: float, pre_trigger: int = 500) -> TriggersInHardware:
    bench.configure(AcquisitionRequest("impact", 2000.0))
    assert isinstance(bench, TriggersInHardware)
    bench.arm(ReferenceTrigger(rig.force_channel.index, level, level / 2, pre_trigger, pre_trigger + 500))
    return bench


def test_what_crosses_before_the_pre_trigger_is_full_is_no_trigger(striking: NiServer, rig: Rig) -> None:
    bench = open_bench(striking.url, rig)
    level = 2.0 * rig.force_channel.sensitivity("impact")
    # The operator strikes a second or two after the start, when five seconds are to be kept.
    waiting = armed(bench, rig, level, 10_000)
    striking.say("strike 10")
    while not waiting.is_armed():
        pass
    with pytest.raises(BenchTimeoutError, match="-200284"):
        waiting.triggered(0.3)
    striking.say("strike 10")
    chunk = waiting.triggered(10.0)
    assert chunk.samples.shape == (len(rig.channels), 10_500)
    assert chunk.samples[0, 9_999] < level <= chunk.samples[0, 10_000]
    bench.stop()
    bench.start()
    assert bench.read(10, 5.0).first_sample == 0
    bench.close()


def test_while_it_waits_nothing_streams_and_a_device_that_goes_is_said(striking: NiServer, rig: Rig) -> None:
    bench = open_bench(striking.url, rig)
    waiting = armed(bench, rig, 0.5)
    with pytest.raises(ConfigurationError, match="armed"):
        bench.read(10, 1.0)
    with pytest.raises(ConfigurationError, match="armed"):
        bench.configure(AcquisitionRequest("impact", 2000.0))
    striking.say("fault unplugged -201003")
    with pytest.raises(DeviceGoneError, match="-201003"):
        waiting.triggered(1.0)
    striking.say("fault plugged")
    bench.configure(AcquisitionRequest("impact", 2000.0))
    bench.start()
    assert bench.read(10, 5.0).first_sample == 0
    bench.close()
    bench.stop()


def test_a_reference_trigger_on_a_negative_sensor_falls(striking: NiServer, rig: Rig) -> None:
    # A turned force transducer gives negative volts for a push: nothing rises above the level then.
    bench = open_bench(striking.url, rig)
    waiting = armed(bench, rig, -2.0 * rig.force_channel.sensitivity("impact"))
    while not waiting.is_armed():
        pass
    striking.say("strike 10")
    with pytest.raises(BenchTimeoutError):
        waiting.triggered(0.3)
    bench.close()
