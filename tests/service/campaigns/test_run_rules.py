"""What an operator may command a run, and what the averages then hold."""

import pytest
from lab import RIG, Lab

from modallab.acquisition.monitor.run_states import TRANSITIONS, IllegalTransitionError
from modallab.acquisition.process.trip import TrippedError
from modallab.core.documents.runs import (
    AbortRun,
    BlockVerdict,
    DropHit,
    PauseRun,
    RepeatFrequency,
    ResumeRun,
    RunRequest,
    StopRun,
)
from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.service.campaigns.live_frf import LiveFrfs
from modallab.service.campaigns.run_start import begin_run
from modallab.service.campaigns.runs import block_records, judge_block, run_view
from modallab.service.errors import ConflictError, LeaseNeededError
from modallab.service.rigs.control import REQUESTED, require_action

LONG = ImpactPlan(points=(10, 6, 3), hits=40)
SHORT_SINE = SinePlan(frequencies_hz=(19.53125, 29.296875), settle_s=2.0, ramp_s=0.5, wait_s=1.0, levels_v={"low": 0.3})
LONG_SINE = SHORT_SINE.model_copy(update={"frequencies_hz": tuple(19.0 + n for n in range(60))})


@pytest.mark.parametrize("state", sorted(TRANSITIONS))
@pytest.mark.parametrize("action", sorted(REQUESTED))
def test_an_action_is_legal_where_the_table_has_a_step_for_it(state, action) -> None:
    legal = REQUESTED[action] in TRANSITIONS[state] and not (action == "resume" and state == "armed")
    if legal:
        require_action(state, action)
    else:
        with pytest.raises(IllegalTransitionError) as rejected:
            require_action(state, action)
        for name in TRANSITIONS[state]:
            assert name in rejected.value.remedy


def test_a_run_pauses_goes_on_drops_a_hit_and_asks_for_it_again(lab: Lab) -> None:
    lease = lab.lease()
    try:
        run = begin_run(lab.service, lab.campaign(), RunRequest(plan=LONG), lease.id)
        kept = lab.wait_for(lambda e: e.run == run and e.kind == "block")
        lab.controllers.command(RIG, run, PauseRun(), lease.id)
        paused = lab.wait_for_state(run, "paused")
        with pytest.raises(IllegalTransitionError, match="paused"):
            lab.controllers.command(RIG, run, PauseRun(), lease.id)
        lab.controllers.command(RIG, run, DropHit(n=0, reason="a slip"), lease.id)
        lab.controllers.command(RIG, run, ResumeRun(), lease.id)
        lab.wait_for(lambda e: e.kind == "dropped" and e.content["name"] == kept.content["name"], paused.seq)
        again = lab.wait_for(lambda e: e.kind == "block" and "_again_1" in e.content["name"], paused.seq)
        assert again.content["name"].startswith(kept.content["name"])
        lab.controllers.command(RIG, run, StopRun(), lease.id)
        lab.wait_for_state(run, "done")
        first = block_records(lab.service, run)[0]
        assert (first.note.accepted, first.note.reason) == (False, "a slip")
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()


def test_a_repeated_frequency_replaces_the_block_before(lab: Lab) -> None:
    lease = lab.lease()
    try:
        run = begin_run(lab.service, lab.campaign(), RunRequest(plan=LONG_SINE), lease.id)
        first = lab.wait_for(lambda e: e.run == run and e.kind == "block")
        with pytest.raises(PlanError, match="123"):
            lab.controllers.command(RIG, run, RepeatFrequency(frequency_hz=123.0), lease.id)
        lab.controllers.command(RIG, run, RepeatFrequency(frequency_hz=19.0), lease.id)
        lab.wait_for(lambda e: e.kind == "dropped" and e.content["name"] == first.content["name"], first.seq)
        lab.controllers.command(RIG, run, StopRun(), lease.id)
        lab.wait_for_state(run, "done")
        at_19 = [b for b in block_records(lab.service, run) if b.note.frequency_hz == 19.0]
        assert [b.note.accepted for b in at_19] == [False, True]
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()


def test_an_emergency_stop_latches_until_the_holder_of_the_lease_resets(lab: Lab) -> None:
    lease = lab.lease("Grace")
    try:
        campaign = lab.campaign()
        run = begin_run(lab.service, campaign, RunRequest(plan=LONG_SINE), lease.id)
        lab.wait_for_state(run, "acquiring")
        lab.controllers.emergency_stop(None, "smoke", "passer-by")
        lab.wait_for_state(run, "aborted")
        assert not run_view(lab.service, run).valid
        lab.wait_until_idle()
        with pytest.raises(TrippedError, match="smoke"):
            begin_run(lab.service, campaign, RunRequest(plan=SHORT_SINE), lease.id)
        with pytest.raises(LeaseNeededError):
            lab.controllers.reset(RIG, "", None)
        lab.controllers.reset(RIG, "looked at it", lease.id)
        run = begin_run(lab.service, campaign, RunRequest(plan=SHORT_SINE), lease.id)
        lab.wait_for_state(run, "done")
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()
    from modallab.service.records.audit import audit_entries

    done = {(entry.operator, entry.action) for entry in audit_entries(lab.service.engine, None, 100)}
    assert {("passer-by", "emergency-stop"), ("Grace", "reset"), ("Grace", "start-run")} <= done


def test_a_rejected_block_leaves_the_average_and_comes_back(lab: Lab) -> None:
    lease = lab.lease()
    try:
        run = begin_run(lab.service, lab.campaign(), RunRequest(plan=ImpactPlan(points=(10,), hits=3)), lease.id)
        lab.wait_for_state(run, "done")
        frfs = LiveFrfs(lab.store)
        whole = frfs.frf(run)
        judge_block(lab.service, run, 1, BlockVerdict(accepted=False, reason="wrong place"), lease.id)
        without = frfs.frf(run)
        judge_block(lab.service, run, 1, BlockVerdict(accepted=True), lease.id)
        again = frfs.frf(run)
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()
    assert (whole.averages, without.averages, again.averages) == ((3,), (2,), (3,))
    assert abs(whole.values - without.values).max() > 0
    assert (whole.values == again.values).all()


def test_an_ended_run_is_continued_with_what_is_left(lab: Lab) -> None:
    lease = lab.lease()
    try:
        campaign = lab.campaign()
        plan = SHORT_SINE.model_copy(update={"frequencies_hz": (19.0, 20.0, 21.0, 22.0, 23.0, 24.0, 25.0, 26.0)})
        run = begin_run(lab.service, campaign, RunRequest(plan=plan), lease.id)
        lab.wait_for(lambda e: e.run == run and e.kind == "block")
        lab.controllers.command(RIG, run, StopRun(), lease.id)
        lab.wait_for_state(run, "done")
        lab.wait_until_idle()
        had = [b.note.frequency_hz for b in block_records(lab.service, run)]
        second = begin_run(lab.service, campaign, RunRequest(continues=run), lease.id)
        lab.wait_for_state(second, "done")
        lab.wait_until_idle()
        new = [b.note.frequency_hz for b in block_records(lab.service, second)]
        assert sorted([*had, *new]) == sorted(plan.frequencies_hz)
        assert lab.service.repository.runs_continued(second) == (run, second)
        with pytest.raises(ConflictError, match="completed its plan"):
            begin_run(lab.service, campaign, RunRequest(continues=second), lease.id)
    finally:
        lab.service.leases.release(RIG, lease.id)


def test_an_aborted_run_is_kept_and_not_continued(lab: Lab) -> None:
    lease = lab.lease()
    try:
        campaign = lab.campaign()
        run = begin_run(lab.service, campaign, RunRequest(plan=LONG), lease.id)
        lab.wait_for(lambda e: e.run == run and e.kind == "block")
        lab.controllers.command(RIG, run, AbortRun(), lease.id)
        lab.wait_for_state(run, "aborted")
        assert block_records(lab.service, run)
        with pytest.raises(ConflictError, match="aborted"):
            begin_run(lab.service, campaign, RunRequest(continues=run), lease.id)
    finally:
        lab.service.leases.release(RIG, lease.id)
        lab.wait_until_idle()
