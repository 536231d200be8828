"""The impact test on a bench whose hits are known to the sample, and on the simulated cantilever."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scripted_bench import ScriptedBench, Strike, scripted_rig

from modallab.acquisition.process.prepare_run import Order
from modallab.acquisition.process.run import record_run, run_plan
from modallab.bench.loader import open_bench
from modallab.core.errors import BenchError, BenchTimeoutError, DeviceGoneError, SamplesLostError
from modallab.core.events import Event
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.storage import BlockRecord, Store

BLOCK = 512
PLAN = ImpactPlan(points=(2, 1), hits=2, block_s=BLOCK / 2000, hit_timeout_s=5.0)


def rows(
    store: Store, bench: ScriptedBench, plan: ImpactPlan = PLAN, chunk_s: float | None = None
) -> list[BlockRecord]:
    with store.begin(plan, scripted_rig(), bench.info) as recorder:
        run_plan(bench, scripted_rig(), plan, recorder, lambda _: None, chunk_s=chunk_s)
    return list(store.catalogue.blocks(recorder.run))


def kinds(events: list[Event]) -> list[str]:
    return [e.state if e.kind == "state" else e.kind for e in events if e.kind not in ("progress", "waiting_for_rest")]


def test_names_points_and_order_are_those_of_the_campaign_format(store: Store) -> None:
    found = rows(store, ScriptedBench())
    assert [(r.note.name, r.note.drive_point, r.count) for r in found] == [
        ("impact_p02_1", 2, BLOCK),
        ("impact_p02_2", 2, BLOCK),
        ("impact_p01_1", 1, BLOCK),
        ("impact_p01_2", 1, BLOCK),
    ]
    assert all(r.note.accepted and r.note.test == "impact" for r in found)


def test_a_block_is_1_024_s_at_2_khz_with_its_pre_trigger(store: Store) -> None:
    (row,) = rows(store, ScriptedBench(), ImpactPlan(points=(1,), hits=1))
    (block,) = store.blocks(row.run)
    assert block.n_samples == 2048
    assert block.duration_s == pytest.approx(1.024)
    force = block.samples[0] * block.scale[0]
    assert force[100] >= 2.0 > force[99]


def test_the_trigger_is_exact_to_the_sample(store: Store) -> None:
    bench = ScriptedBench([Strike(delay=delay) for delay in (201, 333, 1000, 4321)])
    for row, prompt, delay in zip(rows(store, bench), bench.prompts, (201, 333, 1000, 4321), strict=True):
        # 100 N sin^2(pi n / 8) passes 2 N between the contact's start and the next sample.
        assert row.note.first_sample == prompt + delay + 1 - 100


@pytest.mark.thorough("records the same test many times")
@given(st.floats(0.0006, 3.0), st.lists(st.integers(101, 3000), min_size=4, max_size=4))
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_blocks_do_not_depend_on_how_much_is_read_at_once(store: Store, chunk_s: float, delays: list[int]) -> None:
    def recorded(size_s: float) -> list[tuple[object, ...]]:
        bench = ScriptedBench([Strike(delay=delay) for delay in delays])
        return [(r.note, r.crc32, r.count) for r in rows(store, bench, chunk_s=size_s)]

    assert recorded(chunk_s) == recorded(0.05)


def test_on_the_cantilever_blocks_do_not_depend_on_it_either(store: Store, link_rig: Rig) -> None:
    def recorded(size_s: float) -> list[tuple[object, ...]]:
        bench = open_bench("sim://cantilever?seed=3&zeta=0.01", link_rig)
        plan = ImpactPlan(points=(10,), hits=2)
        with store.begin(plan, link_rig, bench.info) as recorder:
            run_plan(bench, link_rig, plan, recorder, lambda _: None, chunk_s=size_s)
        return [(r.note.name, r.note.first_sample, r.crc32) for r in store.catalogue.blocks(recorder.run)]

    assert recorded(0.0371) == recorded(0.5)


def test_events_report_the_run_in_order(store: Store) -> None:
    events: list[Event] = []
    record_run(ScriptedBench(), scripted_rig(), PLAN.model_copy(update={"points": (1,)}), store, events.append)
    assert kinds(events) == [
        *["created", "arming", "armed", "hit_requested", "acquiring", "block", "hit_requested", "block"],
        *["processing", "done"],
    ]
    requested = [e for e in events if e.kind == "hit_requested"]
    assert [(e.point, e.hit, e.of) for e in requested] == [(1, 1, 2), (1, 2, 2)]
    reported = [e for e in events if e.kind == "progress"]
    assert [(e.done, e.total) for e in reported] == [(1, 2), (2, 2)]


@pytest.mark.parametrize(
    ("strike", "reason"),
    [
        (Strike(peak_n=5.0), "too weak: 4.9"),
        (Strike(peak_n=600.0), "overload: force beyond the range"),
        (Strike(second_n=30.0), "double hit"),
        (Strike(width=70), "contact too long"),
        (Strike(response=400.0), "overload: a01, a02 beyond the range"),
    ],
)
def test_a_bad_hit_is_kept_with_its_reason_and_asked_for_again(store: Store, strike: Strike, reason: str) -> None:
    bench = ScriptedBench([strike, Strike()])
    events: list[Event] = []
    run = record_run(bench, scripted_rig(), ImpactPlan(points=(1,), hits=1, block_s=BLOCK / 2000), store, events.append)
    bad, good = store.catalogue.blocks(run)
    assert (bad.note.name, bad.note.accepted, good.note.name) == ("impact_p01_1_rejected_1", False, "impact_p01_1")
    assert bad.note.reason.startswith(reason)
    (rejected,) = [e for e in events if e.kind == "hit_rejected"]
    assert rejected.reason == bad.note.reason
    for event, block in zip([e for e in events if e.kind == "block"], (bad, good), strict=True):
        assert (event.drive_point, event.facts["peak_n"]) == (1, block.note.facts["peak_n"])
        assert {"second_ratio", "drop_db", "contact_s"} <= event.facts.keys()
    assert [b.name for b in store.blocks(run)] == ["impact_p01_1"]


def test_no_hit_is_asked_for_before_the_last_has_rung_down(store: Store) -> None:
    bench = ScriptedBench()
    first, second = rows(store, bench, ImpactPlan(points=(1,), hits=2, block_s=BLOCK / 2000))
    assert second.note.facts["residual_ratio"] == 0
    # 30 m/s^2 are 3000 counts; at rest means less than a third of the 2 counts of noise.
    waited_s = (bench.prompts[1] - first.note.first_sample) / 2000
    assert waited_s > np.log(3000 / 0.66) / (2 * np.pi * 60 * 0.05)


class KnockedBench(ScriptedBench):
    """Somebody knocks against the beam just after each prompt, before the hit."""

    def prompt_hit(self, point: int) -> None:
        super().prompt_hit(point)
        start = self.hits[-1][0]
        self.hits.append((start - 400, Strike(peak_n=0.0, response=5.0)))


def test_a_hit_on_a_beam_that_moves_is_rejected_with_the_line_that_rings(store: Store) -> None:
    bench = KnockedBench([Strike(delay=1000)])
    with pytest.raises(BenchError, match="3 hits at point 1 were rejected"):
        record_run(
            bench,
            scripted_rig(),
            ImpactPlan(points=(1,), hits=1, max_rejections=2, block_s=0.256),
            store,
            lambda _: None,
        )
    (run,) = store.catalogue.runs()
    for row in store.catalogue.blocks(run.id):
        assert "not at rest before" in row.note.reason
        assert float(row.note.reason.split(" Hz")[0].split()[-1]) == pytest.approx(60, abs=4)


def test_no_hit_in_time_ends_the_run_and_keeps_what_there_was(store: Store) -> None:
    bench = ScriptedBench([Strike(), Strike(peak_n=0.5, response=0.0)])
    with pytest.raises(BenchTimeoutError, match="no hit above 2 N at point 2 within 5 s"):
        record_run(bench, scripted_rig(), PLAN, store, lambda _: None)
    (run,) = store.catalogue.runs()
    assert run.state == "failed"
    assert len(store.blocks(run.id)) == 1


def test_lost_samples_cost_one_hit_and_are_never_spliced(store: Store) -> None:
    bench = ScriptedBench(lose_at=[8000])
    events: list[Event] = []
    run = record_run(bench, scripted_rig(), PLAN, store, events.append)
    assert [b.name for b in store.blocks(run)] == ["impact_p02_1", "impact_p02_2", "impact_p01_1", "impact_p01_2"]
    (rejected,) = [e for e in events if e.kind == "hit_rejected"]
    assert "samples were lost: overrun at 8000" in rejected.reason
    assert bench.done.count("stop") == 2


def test_a_device_that_loses_samples_again_and_again_ends_the_run(store: Store) -> None:
    with pytest.raises(SamplesLostError):
        record_run(ScriptedBench(lose_at=[6000, 1100, 1100, 1100]), scripted_rig(), PLAN, store, lambda _: None)


def test_a_device_that_is_gone_ends_the_run_with_its_own_error(store: Store) -> None:
    events: list[Event] = []
    with pytest.raises(DeviceGoneError):
        record_run(ScriptedBench(gone_at=9000), scripted_rig(), PLAN, store, events.append)
    assert kinds(events)[-3:] == ["stopping", "failed", "failed"]
    assert events[-1].kind == "failed"
    assert events[-1].code == "bench-gone"


@pytest.mark.parametrize(("order", "state", "valid"), [("stop", "done", True), ("abort", "aborted", False)])
def test_stop_keeps_the_data_valid_and_abort_marks_them(store: Store, order: Order, state: str, valid: bool) -> None:
    bench = ScriptedBench()
    events: list[Event] = []
    run = record_run(
        bench, scripted_rig(), PLAN, store, events.append, lambda: order if len(bench.prompts) == 3 else None
    )
    found = store.catalogue.run(run)
    assert (found.state, found.valid) == (state, valid)
    assert kinds(events)[-2:] == ["stopping", state]
    assert len(store.blocks(run)) == 2
    assert bench.done[-2:] == ["zero", "stop"]


def test_a_plan_whose_patience_is_over_arms_all_the_same(store: Store) -> None:
    bench = ScriptedBench([Strike(zeta=0.002)])
    plan = ImpactPlan(points=(1,), hits=2, block_s=0.128, pre_trigger_s=0.02, hit_timeout_s=0.3, max_rejections=1)
    with pytest.raises(BenchError):
        record_run(bench, scripted_rig(), plan, store, lambda _: None)
    (run,) = store.catalogue.runs()
    assert "not at rest before" in store.catalogue.blocks(run.id)[1].note.reason
