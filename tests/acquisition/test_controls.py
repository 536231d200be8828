"""A run in its own process is paused, repeated, dropped from outside, and looked at while it goes on."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from modallab.acquisition.monitor.run_states import IllegalTransitionError
from modallab.acquisition.process.rig_process import RigProcess
from modallab.core.errors import PlanError, StorageError
from modallab.core.plan import HitAcceptance, ImpactPlan, SinePlan
from modallab.core.rig import Rig
from modallab.storage import Store, campaign_of

URL = "sim://cantilever?seed=2&zeta=0.01&bad_hits=0"
IMPACT = ImpactPlan(points=(10,), hits=3)
SINE = SinePlan(frequencies_hz=(20.0, 60.0), settle_s=2.0, wait_s=2.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where `shared` records."""
    return tmp_path_factory.mktemp("shared")


@pytest.fixture(scope="module")
def shared(link_rig: Rig, folder: Path) -> Iterator[RigProcess]:
    """One process for those who ask for a run of their own, and not for what comes first in a process."""
    with RigProcess(URL, link_rig, folder) as process:
        yield process


def test_a_run_is_paused_and_goes_on(shared: RigProcess) -> None:
    states: list[str] = []
    for event in shared.run(ImpactPlan(points=(10,), hits=20)):
        if event.kind == "block" and event.n == 0:
            shared.pause()
        if event.kind == "state":
            states.append(event.state)
            if event.state == "paused":
                with pytest.raises(IllegalTransitionError, match="paused cannot become paused"):
                    shared.pause()
                shared.resume()
                shared.stop()
    assert states.count("paused") == 1
    # To stop may overtake going on: both lead from paused to the end.
    assert states[-2:] == ["stopping", "done"]


def test_what_cannot_be_done_now_is_a_typed_error(link_rig: Rig, tmp_path: Path) -> None:
    with RigProcess(URL, link_rig, tmp_path) as process:
        for request in (process.pause, process.resume):
            with pytest.raises(IllegalTransitionError):
                request()
        with pytest.raises(PlanError, match="no block 'impact_p10_1' counts"):
            process.drop("impact_p10_1")
        with pytest.raises(PlanError, match="no run is active"):
            process.repeat(20.0)
        for event in process.run(IMPACT):
            if event.kind == "block" and event.n == 0:
                with pytest.raises(IllegalTransitionError):
                    process.resume()
                with pytest.raises(PlanError, match="no frequencies"):
                    process.repeat(20.0)
        with pytest.raises(IllegalTransitionError, match="done cannot become paused"):
            process.pause()


def test_a_hit_is_dropped_and_asked_for_again_or_after_the_run_left_out(shared: RigProcess, folder: Path) -> None:
    for event in shared.run(IMPACT):
        if event.kind == "block" and event.name == "impact_p10_1":
            shared.drop("impact_p10_1", "the cable moved")
    assert shared.view.blocks == ("impact_p10_2", "impact_p10_1_again_1", "impact_p10_3") or (
        shared.view.blocks == ("impact_p10_1_again_1", "impact_p10_2", "impact_p10_3")
    )
    shared.drop("impact_p10_3", "looked at later")
    run = shared.view.run
    with pytest.raises(PlanError, match="impact_p10_3"):
        shared.drop("impact_p10_3")
    with Store(folder) as store:
        assert len(campaign_of(store, [run]).blocks) == 2
        reasons = {r.note.name: r.note.reason for r in store.catalogue.blocks(run) if not r.note.accepted}
        assert reasons == {"impact_p10_1": "the cable moved", "impact_p10_3": "looked at later"}
        with pytest.raises(StorageError, match="has no valid block 'impact_p10_3'"):
            store.drop_block(run, "impact_p10_3")


def test_a_frequency_is_repeated_in_the_run(shared: RigProcess) -> None:
    for event in shared.run(SINE):
        if event.kind == "block" and event.name == "sine_low_020.000":
            with pytest.raises(PlanError, match="not been recorded yet"):
                shared.repeat(60.0)
            shared.repeat(20.0)
    assert set(shared.view.blocks) == {"sine_low_020.000_again_1", "sine_low_060.000"}


def test_progress_and_the_last_block_are_there_while_the_run_goes_on(link_rig: Rig, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    with RigProcess(URL, link_rig, tmp_path) as process:
        assert process.last_block() is None
        for event in process.run(IMPACT):
            if event.kind == "hit_requested":
                assert process.view.requested == event
            if event.kind == "block":
                block = process.last_block()
                assert block is not None
                assert block.name == event.name
                assert np.abs(block.samples[0]).max() > 100
            if event.kind == "progress" and "hit" in event.what:
                seen.append((process.view.done, process.view.total))
    assert seen == [(1, 3), (2, 3), (3, 3)]


def test_before_anything_is_driven_it_is_said_how_long_the_longest_burst_lasts(shared: RigProcess) -> None:
    events = list(shared.run(SINE))
    kinds = [e.state if e.kind == "state" else e.kind for e in events]
    assert kinds.index("notice") < kinds.index("armed")
    (notice,) = [e for e in events if e.kind == "notice"]
    # settle 2 s, block 1.024 s, margin 0.1 s, ramp 1 s
    assert "longest burst 4.124 s" in notice.what
    assert "ends with the process" in notice.what


def test_the_operator_decides_of_every_hit_whether_it_counts(shared: RigProcess) -> None:
    plan = ImpactPlan(points=(10,), hits=2, operator_decides="every")
    asked: list[str] = []
    for event in shared.run(plan):
        if event.kind == "decision_requested":
            asked.append(event.name)
            assert event.accepted
            assert shared.view.undecided == event.name
            if len(asked) == 1:
                shared.drop(event.name, "beside the point")
            else:
                shared.accept(event.name, "good", "Ada")
    assert asked == ["impact_p10_1", "impact_p10_1_again_1", "impact_p10_2"]
    assert shared.view.blocks == ("impact_p10_1_again_1", "impact_p10_2")


def test_the_operator_decides_of_rejected_hits_only(link_rig: Rig, tmp_path: Path) -> None:
    plan = ImpactPlan(points=(10,), hits=1, operator_decides="rejected", acceptance=HitAcceptance(min_force_n=479.0))
    decisions: list[str] = []
    with RigProcess(URL, link_rig, tmp_path) as process:
        for event in process.run(plan):
            if event.kind == "decision_requested":
                assert not event.accepted
                assert "at least 479 N" in event.reason
                if not decisions:
                    process.drop(event.name, "indeed")
                else:
                    process.accept(event.name, "strong enough", "Ada")
                decisions.append(event.name)
        assert decisions == ["impact_p10_1_rejected_1", "impact_p10_1_rejected_2"]
        assert process.view.blocks == ("impact_p10_1_rejected_2",)


def test_what_was_dropped_is_taken_back_until_it_is_struck_again(shared: RigProcess) -> None:
    for event in shared.run(ImpactPlan(points=(10,), hits=2, operator_decides="every")):
        if event.kind == "decision_requested" and event.name == "impact_p10_1":
            shared.pause()
            shared.drop(event.name, "a slip")
            shared.accept(event.name, "no slip", "Ada")
            shared.resume()
        elif event.kind == "decision_requested":
            shared.accept(event.name, "good", "Ada")
    assert shared.view.blocks == ("impact_p10_1", "impact_p10_2")
