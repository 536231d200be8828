"""What is computed of runs is of the blocks that count when it is asked for."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from recorded_run import record_run

from modallab.core.documents.results import JobRequest
from modallab.core.documents.runs import BlockVerdict, CampaignRequest
from modallab.jobs import Job
from modallab.jobs.attempt import JobAttempt
from modallab.jobs.leases import JobLeases
from modallab.pipelines.job_kinds import campaigns_of, kinds
from modallab.service.campaigns.runs import judge_block
from modallab.service.context import Service, open_service
from modallab.service.jobs.background import IdentificationAfterRun
from modallab.service.jobs.campaign_jobs import order_job
from modallab.service.records.leases import RigLeases as RigLeases
from modallab.service.records.repository import RunEntry
from modallab.service.rigs.controllers import RigControllers
from modallab.storage import Store

RIG = "small"


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with Store(tmp_path / "data") as store:
        nobody = RigControllers([], RigLeases(store.catalogue.engine, "start"))
        opened = open_service(tmp_path / "data", nobody, "start")
        yield opened
        opened.close()


@pytest.fixture
def campaign(service: Service) -> str:
    return service.repository.create(CampaignRequest(name="a session", rig=RIG), "Ada").id


def _record(service: Service, campaign: str, continues: str | None = None) -> str:
    run = record_run(service.store, blocks=6)
    service.repository.add_run(RunEntry(run, campaign, RIG, "Ada", continues), {})
    return run


def _judge(service: Service, run: str, accepted: bool, *numbers: int) -> None:
    for n in numbers:
        service.store.catalogue.judge_block(run, n, accepted=accepted, reason="", operator="Ada", utc="")


def _done(service: Service, job: Job) -> None:
    leases = JobLeases(service.engine, "a runner")
    (taken,) = leases.lease_jobs([job.kind], 1)
    assert taken.job.id == job.id
    assert leases.complete(taken, {"model of": job.id})


@pytest.mark.parametrize("kind", ["identify", "report", "diagnose"])
def test_who_asks_again_after_a_verdict_has_it_computed_anew(service: Service, campaign: str, kind) -> None:
    run = _record(service, campaign)
    first = order_job(service, campaign, kind, JobRequest(), "Ada")
    _done(service, first)
    assert order_job(service, campaign, kind, JobRequest(), "Ada").id == first.id
    _judge(service, run, False, 0, 1, 2)
    second = order_job(service, campaign, kind, JobRequest(), "Ada")
    assert (second.state, second.result) == ("queued", None)
    _done(service, second)
    # Where the verdicts are taken back it is the first work again, and the newest of the campaign.
    _judge(service, run, True, 0, 1, 2)
    assert order_job(service, campaign, kind, JobRequest(), "Ada").id == first.id
    assert service.repository.jobs(campaign, kind) == [first.id, second.id]


def test_a_run_that_continues_a_judged_one_is_identified_anew(service: Service, campaign: str) -> None:
    before = _record(service, campaign)
    run = _record(service, campaign, before)
    after = IdentificationAfterRun(service.store, service.jobs)
    first = after.identify(run)
    assert after.identify(run).id == first.id
    _judge(service, before, False, 5)
    assert after.identify(run).id != first.id


def test_a_block_that_is_judged_before_its_job_begins_is_not_passed_over(service: Service, campaign: str) -> None:
    run = _record(service, campaign)
    job = order_job(service, campaign, "identify", JobRequest(), "Ada")
    _judge(service, run, False, 0)
    (kind, *_) = kinds(campaigns_of(service.store), service.folder, service.store.revision)
    leases = JobLeases(service.engine, "a runner")
    (taken,) = leases.lease_jobs(["identify"], 1)
    JobAttempt(taken, kind, leases, client=None).run()
    ended = service.jobs.get(job.id)
    assert ended.state == "failed"
    assert "valid blocks have changed" in str(ended.error)
    assert "order it again" in str(ended.error)
    assert order_job(service, campaign, "identify", JobRequest(), "Ada").state == "queued"


def _verdict(service: Service, run: str, accepted: bool, *numbers: int) -> None:
    for n in numbers:
        judge_block(service, run, n, BlockVerdict(accepted=accepted), None, "Ada")


def test_a_verdict_while_jobs_wait_has_them_done_with_what_counts_now(service: Service, campaign: str) -> None:
    run = _record(service, campaign)
    automatic = IdentificationAfterRun(service.store, service.jobs).identify(run)
    ordered = order_job(service, campaign, "report", JobRequest(), "Ada")
    _verdict(service, run, False, 0)
    for old, kind in ((automatic, "identify"), (ordered, "report")):
        ended = service.jobs.get(old.id)
        newest = service.jobs.get(service.repository.jobs(campaign, kind)[0])
        assert (ended.state, newest.state) == ("cancelled", "queued")
        assert newest.id in str(ended.error)
        assert newest.revision == service.store.revision([run])
    # Taken back before any of it was computed, it is ordered once more.
    _verdict(service, run, True, 0)
    (again, *_) = service.repository.jobs(campaign, "identify")
    assert service.jobs.get(again).state == "queued"
    assert service.jobs.get(again).revision == automatic.revision


def test_what_a_person_waits_for_stays_before_what_is_done_by_itself(service: Service, campaign: str) -> None:
    run = _record(service, campaign)
    IdentificationAfterRun(service.store, service.jobs).identify(run)
    order_job(service, campaign, "report", JobRequest(), "Ada")
    _verdict(service, run, False, 0)
    (taken,) = JobLeases(service.engine, "a runner").lease_jobs(["identify", "report"], 1)
    assert taken.job.kind == "report"


def test_a_job_that_is_computed_while_a_block_is_judged_is_not_kept(service: Service, campaign: str) -> None:
    run = _record(service, campaign)
    job = IdentificationAfterRun(service.store, service.jobs).identify(run)
    leases = JobLeases(service.engine, "a runner")
    (taken,) = leases.lease_jobs(["identify"], 1)
    _verdict(service, run, False, 0)
    assert not leases.complete(taken, {"model of": job.id})
    assert service.jobs.get(job.id).state == "cancelled"


def test_where_no_block_counts_nothing_waits_until_one_does_again(service: Service, campaign: str) -> None:
    run = _record(service, campaign)
    IdentificationAfterRun(service.store, service.jobs).identify(run)
    _verdict(service, run, False, *range(6))
    assert not service.jobs.list(state="queued").jobs
    _verdict(service, run, True, 2)
    (waits,) = service.jobs.list(state="queued").jobs
    assert (waits.kind, waits.inputs) == ("identify", (run,))


def test_a_verdict_after_the_model_orders_nothing_by_itself(service: Service, campaign: str) -> None:
    run = _record(service, campaign)
    _done(service, IdentificationAfterRun(service.store, service.jobs).identify(run))
    _verdict(service, run, False, 0)
    assert not service.jobs.list(state="queued").jobs
