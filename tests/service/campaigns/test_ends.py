"""Every run has one end, reported once, whoever finds it out first; and what was asked for at a bad moment begins."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event as Flag
from threading import Thread

import pytest
from lab import RIG, Lab

from modallab.acquisition.process.rig_process import RigProcess
from modallab.bench.protocol import BenchInfo
from modallab.core.documents.pages import EventView
from modallab.core.documents.runs import CampaignRequest, RunRequest, StopRun
from modallab.core.errors import DeviceGoneError
from modallab.core.events import RunState, StateChanged
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.service.campaigns.run_start import begin_run
from modallab.service.errors import RigUnavailableError
from modallab.service.records.event_log import EventLog, EventTopic
from modallab.service.records.repository import RunEntry
from modallab.service.rigs.active_run import RequestedRun
from modallab.service.rigs.control import StartRun
from modallab.service.rigs.run_log import RunLog, RunRecovery
from modallab.storage import Store
from modallab.storage.records import ENDED

LONG = ImpactPlan(points=(10, 6, 3), hits=40)


def _of(run_log: RunLog, run: str, kind: str) -> list[EventView]:
    return [event for event in run_log.log.events_after(0, 10_000) if event.run == run and event.kind == kind]


def _ends(run_log: RunLog, run: str) -> list[EventView]:
    return [event for event in _of(run_log, run, "state") if event.content["state"] in ENDED]


@contextmanager
def _looking_all_the_time(recovery: RunRecovery) -> Iterator[None]:
    enough = Flag()

    def check_now() -> None:
        while not enough.wait(0.002):
            recovery.check_now()

    thread = Thread(target=check_now)
    thread.start()
    try:
        yield
    finally:
        enough.set()
        thread.join()


@pytest.mark.thorough("kills the rig's process under a run, and waits for the recovery")
def test_a_rig_that_dies_under_the_eyes_of_the_recovery_ends_its_run_once(lab: Lab) -> None:
    lease, campaign = lab.lease(), lab.campaign()
    try:
        with _looking_all_the_time(RunRecovery(lab.run_log, look_s=0.0)):
            for _ in range(3):
                run = begin_run(lab.service, campaign, RunRequest(plan=LONG), lease.id)
                lab.wait_for(lambda e, run=run: e.run == run and e.kind == "block")
                os.kill(lab.controller.pid or 0, signal.SIGKILL)
                lab.wait_for(lambda e, run=run: e.run == run and e.kind == "failed")
                lab.wait_until_idle()
                assert [end.content["state"] for end in _ends(lab.run_log, run)] == ["failed"]
                assert len(_of(lab.run_log, run, "failed")) == 1
                assert "interrupted" in lab.store.catalogue.run(run).reason
    finally:
        lab.service.leases.release(RIG, lease.id)


def _recorded(store: Store, run_log: RunLog, rig: Rig, state: RunState, reported: RunState) -> str:
    """A run that stands at `state` on the disk, of which the log heard up to `reported`."""
    info = BenchInfo("sim://somewhere", (), True, False, {})
    campaign = run_log.repository.create(CampaignRequest(name="a session", rig="link"), "Ada").id
    with store.begin(LONG, rig, info) as recorder:
        if state != "created":
            recorder.enter_state(state, "as the rig said")
        run_log.repository.add_run(RunEntry(recorder.run, campaign, "link", "Ada", None), {})
        said = StateChanged(run=recorder.run, state=reported)
        run_log.log.append("state", EventTopic("link", campaign, recorder.run), said.model_dump())
        return recorder.run


def test_an_end_that_the_service_did_not_live_to_report_is_reported_at_its_next_start(
    tmp_path: Path, link_rig: Rig
) -> None:
    with Store(tmp_path / "data") as store:
        run_log = RunLog(store, EventLog(store.catalogue.engine))
        done = _recorded(store, run_log, link_rig, "done", "acquiring")
        lost = _recorded(store, run_log, link_rig, "failed", "acquiring")
        dead = _recorded(store, run_log, link_rig, "created", "created")
        reported = _recorded(store, run_log, link_rig, "done", "done")
        for _ in range(2):
            ended: list[str] = []
            again = RunLog(store, EventLog(store.catalogue.engine))
            RunRecovery(again, ended.append).check_now()
        assert ended == []
        for run, state in ((done, "done"), (lost, "failed"), (dead, "failed"), (reported, "done")):
            (end,) = _ends(run_log, run)
            assert end.content["state"] == state
            assert (end.rig, end.campaign != "") == ("link", True)
        codes = {run: getattr(run_log.repository.run_entry(run), "code", None) for run in (done, lost, dead)}
        assert codes == {done: "", lost: "interrupted", dead: "interrupted"}


def test_whoever_follows_a_run_reports_its_end(tmp_path: Path, link_rig: Rig) -> None:
    with Store(tmp_path / "data") as store:
        run_log = RunLog(store, EventLog(store.catalogue.engine))
        run = _recorded(store, run_log, link_rig, "failed", "acquiring")
        ended: list[str] = []
        recovery = RunRecovery(run_log, ended.append, look_s=0.0)
        for name in (run, ""):
            with run_log.ends.following(type("Active", (), {"run": name})()):
                recovery.check_now()
            assert ended == []
        recovery.check_now()
        recovery.check_now()
        assert ended == [run]


def test_a_run_begins_though_the_rig_s_process_has_just_gone(lab: Lab) -> None:
    lease, campaign = lab.lease(), lab.campaign()
    order = StartRun(RIG, campaign, LONG, lease.id, None)
    try:
        lab.wait_until_idle()
        process = lab.controller._process
        assert isinstance(process, RigProcess)
        process.process.kill()
        process.process.join()
        # The controller has not seen it yet, for a tenth of a second; then it says that it is starting.
        try:
            run = lab.controllers.start(order)
        except RigUnavailableError:
            lab.wait_until_idle()
            run = lab.controllers.start(order)
        lab.wait_for(lambda e: e.run == run and e.kind == "block")
        lab.controllers.command(RIG, run, StopRun(), lease.id)
        lab.wait_for_state(run, "done")
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()


def test_what_could_not_begin_in_time_does_not_begin_later() -> None:
    order = StartRun("link", "c1", LONG, "", None)
    late = RequestedRun(order, "Ada")
    with pytest.raises(RigUnavailableError, match=r"not started after 0\.01 s") as rejected:
        late.wait_for_name(0.01)
    assert rejected.value.remedy == "try again when the rig is idle"
    assert not late.claim()

    on_its_way = RequestedRun(order, "Ada")
    assert on_its_way.claim()
    with pytest.raises(RigUnavailableError) as unsure:
        on_its_way.wait_for_name(0.01)
    assert unsure.value.remedy == "read the campaign's list of runs"
    # The rig's process died of it; it was not given up, since nobody could know.
    on_its_way.return_to_queue()
    assert on_its_way.claim()

    put_back = RequestedRun(order, "Ada")
    assert put_back.claim()
    put_back.return_to_queue()
    with pytest.raises(RigUnavailableError):
        put_back.wait_for_name(0.01)
    assert not put_back.claim()


def test_a_bench_that_cannot_be_opened_has_one_remedy_its_own() -> None:
    kept_from = str(DeviceGoneError("no device Dev1", where="nidaqmx://Dev1", remedy="plug it in"))
    error = RigUnavailableError.of("the rig is unavailable", kept_from, "link")
    assert str(error) == ("link: the rig is unavailable: nidaqmx://Dev1: no device Dev1\n  what to do: plug it in")
    starting = RigUnavailableError.of("the rig is starting", "", "link")
    assert starting.what == "the rig is starting"
    assert starting.remedy.startswith("wait until the rig is idle")
