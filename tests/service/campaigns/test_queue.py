"""The queue of a rig: what is run next, and what never begins by itself."""

import os
import signal
import time
from collections.abc import Callable, Iterator

import psutil
import pytest
from lab import RIG, TOKEN, Lab

from modallab.client import Client, ServiceProblemError
from modallab.core.documents.queue import ConsentRequest, QueueItem, QueueItemRequest
from modallab.core.documents.rigs import Lease
from modallab.core.documents.runs import RunRequest, StopRun
from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.service.api.rigs import process_state
from modallab.service.campaigns import queueing
from modallab.service.campaigns.run_start import begin_run
from modallab.service.errors import LeaseNeededError
from modallab.service.records.run_queue import RunQueue
from modallab.service.rigs.queue_runner import QueueRunner

HIT = ImpactPlan(points=(10,), hits=1)
LONG = ImpactPlan(points=(10,), hits=60)
SINE = SinePlan(frequencies_hz=(19.53125,), settle_s=2.0, ramp_s=0.5, wait_s=1.0, levels_v={"low": 0.3})


@pytest.fixture(scope="module", autouse=True)
def runner(lab: Lab) -> Iterator[QueueRunner]:
    running = QueueRunner(lab.controllers, lab.run_log)
    yield running
    running.close()


@pytest.fixture
def lease(lab: Lab) -> Iterator[Lease]:
    lab.wait_until_idle()
    held = lab.lease()
    yield held
    queue = RunQueue(lab.service.engine)
    for item in queue.open(RIG):
        if item.state == "waiting":
            queue.take_out(RIG, item.id, "", "tests")
    queue.resume(RIG, "tests")
    lab.controllers.withdraw_consent(RIG)
    last = lab.service.leases.take(RIG, "Ada", 60.0, take_over=True)
    lab.service.leases.release(RIG, last.id)
    lab.wait_until_idle()


def queued(lab: Lab, *plans: Plan) -> list[str]:
    rig, campaign = process_state(lab.service, RIG), lab.campaign()
    return [queueing.queue_run(lab.service, rig, QueueItemRequest(campaign=campaign, plan=p), "Otto").id for p in plans]


def consent(lab: Lab, lease: Lease, **what: bool) -> None:
    queueing.give_consent(lab.service, RIG, ConsentRequest.model_validate(what), lease.id)


def item(lab: Lab, name: str) -> QueueItem:
    return RunQueue(lab.service.engine).item(name)


def until(happened: Callable[[], bool], within_s: float = 240.0) -> None:
    end = time.monotonic() + within_s
    while not happened():
        assert time.monotonic() < end
        time.sleep(0.02)


def nothing_begins(lab: Lab, runner: QueueRunner) -> bool:
    runs = len(lab.store.catalogue.runs())
    for _ in range(3):
        runner.check_now()
    return len(lab.store.catalogue.runs()) == runs


def waits_for(lab: Lab) -> str:
    return queueing.queue_view(lab.service, process_state(lab.service, RIG)).waits_for


def test_runs_begin_one_after_the_other_once_their_operator_stands_there(lab: Lab, lease: Lease, runner) -> None:
    names = queued(lab, HIT, HIT)
    assert nothing_begins(lab, runner)
    assert "no holder of the lease has consented" in waits_for(lab)
    consent(lab, lease, drive=True)
    assert nothing_begins(lab, runner)
    assert "has not confirmed to be at the bench" in waits_for(lab)
    consent(lab, lease, at_bench=True)
    until(lambda: item(lab, names[1]).state == "done")
    first, second = (item(lab, name) for name in names)
    assert first.state == "done"
    assert first.run < second.run
    entry = lab.service.repository.run_entry(first.run)
    assert entry is not None
    assert (entry.operator, first.operator) == ("Ada", "Otto")


def test_a_shaker_starts_only_by_the_consent_of_who_holds_the_lease_to_that_very_test(lab, lease, runner) -> None:
    (first,) = queued(lab, SINE)
    consent(lab, lease, at_bench=True)
    assert nothing_begins(lab, runner)
    assert "has not consented to tests that move the output" in waits_for(lab)
    with pytest.raises(LeaseNeededError):
        queueing.give_consent(lab.service, RIG, ConsentRequest(drive=True), None)
    consent(lab, lease, drive=True)
    (later,) = queued(lab, SINE)
    until(lambda: item(lab, first).state == "done")
    assert nothing_begins(lab, runner)
    assert "was given before this run was queued" in waits_for(lab)
    assert item(lab, later).state == "waiting"


def test_with_the_lease_the_consent_ends(lab: Lab, lease: Lease, runner) -> None:
    queued(lab, SINE)
    queueing.pause_queue(lab.service, RIG, "", "Otto")
    consent(lab, lease, drive=True)
    lab.service.leases.release(RIG, lease.id)
    again = lab.lease()
    queueing.resume_queue(lab.service, RIG, again.id)
    assert nothing_begins(lab, runner)
    assert lab.controllers.consent_view(RIG) is None


def test_a_run_begun_by_hand_ends_the_consent(lab: Lab, lease: Lease, runner) -> None:
    queueing.pause_queue(lab.service, RIG, "", "Otto")
    queued(lab, SINE)
    consent(lab, lease, drive=True)
    run = begin_run(lab.service, lab.campaign(), RunRequest(plan=HIT), lease.id)
    lab.wait_for_ended(run)
    lab.wait_until_idle()
    queueing.resume_queue(lab.service, RIG, lease.id)
    assert nothing_begins(lab, runner)


def test_a_run_that_does_not_end_well_pauses_the_queue_with_its_reason(lab: Lab, lease: Lease, runner) -> None:
    first, _ = queued(lab, LONG, HIT)
    consent(lab, lease, at_bench=True)
    until(lambda: item(lab, first).run != "")
    lab.wait_for(lambda e: e.run == item(lab, first).run and e.kind == "block")
    lab.controllers.command(RIG, item(lab, first).run, StopRun(), lease.id)
    until(lambda: item(lab, first).state == "failed")
    lab.wait_until_idle()
    assert nothing_begins(lab, runner)
    view = queueing.queue_view(lab.service, process_state(lab.service, RIG), ended=True)
    assert (view.paused, "stopped by the operator" in view.reason, view.consent) == (True, True, None)
    queueing.resume_queue(lab.service, RIG, lease.id)
    # Whoever resumes has not consented yet.
    assert nothing_begins(lab, runner)


def test_an_emergency_stop_pauses_it_also_while_nothing_is_on(lab: Lab, lease: Lease, runner) -> None:
    queueing.pause_queue(lab.service, RIG, "", "Otto")
    queued(lab, SINE)
    consent(lab, lease, drive=True)
    queueing.resume_queue(lab.service, RIG, lease.id)
    lab.controllers.emergency_stop(RIG, "smoke", "passer-by")
    lab.controllers.reset(RIG, "looked at it", lease.id)
    until(lambda: RIG in RunQueue(lab.service.engine).paused())
    assert "had an emergency stop" in RunQueue(lab.service.engine).paused()[RIG]
    assert lab.controllers.consent_view(RIG) is None


def test_a_rig_process_that_was_started_anew_starts_no_shaker(lab: Lab, lease: Lease, runner) -> None:
    queueing.pause_queue(lab.service, RIG, "", "Otto")
    queued(lab, SINE)
    consent(lab, lease, drive=True)
    before = lab.controllers.pid(RIG)
    assert before is not None
    os.kill(before, signal.SIGKILL)
    until(lambda: lab.controllers.pid(RIG) not in (before, None) and not psutil.pid_exists(before))
    lab.wait_until_idle()
    queueing.resume_queue(lab.service, RIG, lease.id)
    until(lambda: RIG in RunQueue(lab.service.engine).paused())
    assert "was restarted" in RunQueue(lab.service.engine).paused()[RIG]
    assert nothing_begins(lab, runner)


def test_what_was_claimed_as_the_service_died_waits_again_and_is_not_run_twice(lab: Lab, lease: Lease, runner) -> None:
    (name,) = queued(lab, HIT)
    queue = RunQueue(lab.service.engine)
    assert queue.claim(name)
    until(lambda: item(lab, name).state == "waiting")
    consent(lab, lease, at_bench=True)
    until(lambda: item(lab, name).state == "done")
    run = item(lab, name).run
    # As if the run's name had not been kept.
    queue.set_state(name, "running")
    until(lambda: item(lab, name).state == "done")
    assert item(lab, name).run == run


def test_a_plan_is_looked_at_when_it_is_queued(lab: Lab, lease: Lease) -> None:
    rig, campaign = process_state(lab.service, RIG), lab.campaign()
    for plan in (ImpactPlan(points=(99,)), SINE.model_copy(update={"levels_v": {"low": 99.0}})):
        with pytest.raises(PlanError):
            queueing.queue_run(lab.service, rig, QueueItemRequest(campaign=campaign, plan=plan), "Otto")


def test_about_how_long_a_run_takes_is_said(lab: Lab) -> None:
    assert queueing.duration_s(SINE) == pytest.approx(2.0 + 1.024 + 0.5 + 1.0, rel=0.1)
    assert queueing.duration_s(LONG) == pytest.approx(60 * 16.024)


def test_by_the_client_a_queue_is_filled_ordered_skipped_paused_and_resumed(lab: Lab, lease: Lease) -> None:
    with Client(lab.url, TOKEN, "Grace") as client:
        client.pause_queue(RIG, "the clamp is loose")
        campaign = lab.campaign()
        one, two, three = (client.queue_run(RIG, campaign, HIT, note=n).id for n in ("a", "b", "c"))
        assert [i.id for i in client.reorder_queue(RIG, [three, one, two]).items] == [three, one, two]
        with pytest.raises(ServiceProblemError, match="not the 3 waiting ones"):
            client.reorder_queue(RIG, [one, two])
        assert client.skip_queued(RIG, one, "not needed").state == "skipped"
        view = client.queue(RIG)
        assert ([i.note for i in view.items], view.reason) == (["c", "b"], "the clamp is loose")
        assert view.remaining_s == pytest.approx(2 * 16.024)
        given = client.give_consent(RIG, lease, drive=True).consent
        assert given is not None
        assert (given.operator, set(given.items)) == ("Ada", {two, three})
        assert client.withdraw_consent(RIG).consent is None
        assert not client.resume_queue(RIG, lease).paused
        assert [i.note for i in client.queue(RIG, ended=True).items][:3] == ["c", "b", "a"]
        with pytest.raises(ServiceProblemError, match="is skipped"):
            client.skip_queued(RIG, one)
    lab.wait_for(lambda e: e.kind == "queue" and e.content["state"] == "done")
    events = [e.content["state"] for e in lab.events("queue")]
    assert {"waiting", "skipped", "paused", "resumed", "consent", "reordered", "done"} <= set(events)
