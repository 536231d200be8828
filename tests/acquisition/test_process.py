"""A rig in its own process: both tests end to end, orders, errors, and a death."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from modallab.acquisition.process.rig_process import RigProcess
from modallab.core.errors import BenchError, ConfigurationError, PlanError
from modallab.core.events import Event
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.storage import Store, campaign_of

URL = "sim://cantilever?seed=2&zeta=0.01"
IMPACT = ImpactPlan(points=(10,), hits=2)
SINE = SinePlan(frequencies_hz=(20.0, 60.0), settle_s=2.0, wait_s=2.0)


def run_of(events: list[Event]) -> str:
    (run,) = {event.run for event in events}
    return run


@pytest.fixture(scope="module")
def shared(link_rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RigProcess]:
    """One process for those who look at no more than their own runs."""
    with RigProcess(URL, link_rig, tmp_path_factory.mktemp("shared")) as process:
        yield process


def test_both_tests_end_to_end_and_the_campaign_they_make(link_rig: Rig, tmp_path: Path) -> None:
    with RigProcess(URL, link_rig, tmp_path) as process:
        assert process.info.can_drive
        runs = [run_of(list(process.run(plan))) for plan in (IMPACT, SINE)]
    assert not process.process.is_alive()
    with Store(tmp_path) as store:
        campaign = campaign_of(store, runs)
        assert [r.state for r in store.catalogue.runs()] == ["done", "done"]
    assert [len(campaign.of("impact")), len(campaign.of("sine"))] == [2, 2]
    assert {b.rate_hz for b in campaign.of("impact")} == {2000.0}
    assert campaign.provenance["bench.seed"] == "2"


@pytest.mark.parametrize(("order", "state"), [("stop", "done"), ("abort", "aborted")])
def test_orders_reach_a_run_and_the_process_is_ready_for_the_next(shared: RigProcess, order: str, state: str) -> None:
    events: list[Event] = []
    for event in shared.run(ImpactPlan(points=(10,), hits=500)):
        events.append(event)
        if event.kind == "block" and event.n == 0:
            getattr(shared, order)()
    ended = events[-1]
    assert ended.kind == "state"
    assert ended.state == state
    assert run_of(list(shared.run(SINE))) != run_of(events)


def test_leaving_the_events_early_stops_the_run(link_rig: Rig, tmp_path: Path) -> None:
    with RigProcess(URL, link_rig, tmp_path) as process:
        events = process.run(ImpactPlan(points=(10,), hits=500))
        next(e for e in events if e.kind == "block")
        events.close()
        list(process.run(SINE))
    with Store(tmp_path) as store:
        assert [r.state for r in store.catalogue.runs()] == ["done", "done"]


def test_closing_in_a_run_ends_it_as_interrupted_in_good_order(link_rig: Rig, tmp_path: Path) -> None:
    with RigProcess(URL, link_rig, tmp_path) as process:
        events = process.run(ImpactPlan(points=(10,), hits=500))
        next(e for e in events if e.kind == "block")
    assert process.process.exitcode == 0
    with Store(tmp_path) as store:
        (run,) = store.catalogue.runs()
        assert (run.state, run.reason) == ("failed", "interrupted: the service was ended")


def test_an_error_arrives_as_itself_after_its_events_and_the_process_goes_on(shared: RigProcess) -> None:
    impossible: Plan = SinePlan(levels_v={"low": 50.0})
    events: list[Event] = []
    with pytest.raises(PlanError, match="low is 50 V; allowed by the rig"):
        events.extend(shared.run(impossible))
    assert events[-1].kind == "failed"
    list(shared.run(SINE))


def test_a_bench_that_cannot_be_opened_says_why(link_rig: Rig, tmp_path: Path) -> None:
    with (
        RigProcess("nothing://here", link_rig, tmp_path) as process,
        pytest.raises(ConfigurationError, match="no driver"),
    ):
        list(process.run(SINE))
    with (
        RigProcess("sim://cantilever?seed=x", link_rig, tmp_path) as process,
        pytest.raises(ConfigurationError, match="seed"),
    ):
        list(process.run(SINE))


def test_a_killed_process_is_reported_and_its_blocks_are_kept(link_rig: Rig, tmp_path: Path) -> None:
    with RigProcess(URL, link_rig, tmp_path) as process:
        acknowledged: list[str] = []
        events = process.run(ImpactPlan(points=(10,), hits=500))
        acknowledged.append(next(e for e in events if e.kind == "block").name)
        process.process.kill()
        with pytest.raises(BenchError, match="the acquisition process ended"):
            acknowledged.extend(e.name for e in events if e.kind == "block")
    with Store(tmp_path) as store:
        (run,) = store.catalogue.runs()
        assert (run.state, run.reason) == ("failed", "interrupted")
        assert {b.name for b in store.blocks(run.id, rejected=True)} >= set(acknowledged)
