"""Campaigns and runs that are archived, deleted and restored: nothing is lost before the grace time ends."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from recorded_run import record_run

from modallab.bench.protocol import BenchInfo
from modallab.core.documents.queue import QueueItemRequest
from modallab.core.documents.results import JobRequest
from modallab.core.documents.runs import CampaignRequest
from modallab.core.errors import StorageError
from modallab.core.plan import ImpactPlan
from modallab.jobs.leases import JobLeases as JobLeases
from modallab.service.campaigns.export import export_campaign
from modallab.service.campaigns.purge import PurgeTimer
from modallab.service.campaigns.runs import run_view
from modallab.service.context import Service, open_service
from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.jobs.campaign_jobs import order_job
from modallab.service.records.archive import ArchivedRecords
from modallab.service.records.leases import RigLeases
from modallab.service.records.repository import RunEntry
from modallab.service.records.run_queue import RunQueue
from modallab.service.rigs.controllers import RigControllers
from modallab.storage import Store

RIG = "small"
GRACE = timedelta(days=30)


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with Store(tmp_path / "data") as store:
        opened = open_service(
            tmp_path / "data", RigControllers([], RigLeases(store.catalogue.engine, "start")), "start"
        )
        yield opened
        opened.close()


@pytest.fixture
def aside(service: Service) -> ArchivedRecords:
    return ArchivedRecords(service.engine)


@pytest.fixture
def campaign(service: Service) -> str:
    return service.repository.create(CampaignRequest(name="a session", rig=RIG), "Ada").id


def record(service: Service, campaign: str, continues: str | None = None) -> str:
    run = record_run(service.store, blocks=2)
    service.repository.add_run(RunEntry(run, campaign, RIG, "Ada", continues), {})
    return run


class Clocks:
    """A time of day and a monotonic clock, which somebody sets."""

    def __init__(self) -> None:
        self.day, self.s = datetime.now(UTC), 0.0

    def go_on(self, by: timedelta) -> None:
        self.day, self.s = self.day + by, self.s + by.total_seconds()

    def purge(self, service: Service) -> PurgeTimer:
        return PurgeTimer(service.store, 1.0, lambda: self.day, lambda: self.s)


def samples(service: Service, run: str) -> int:
    return sum(block.samples.size for block in service.store.blocks(run))


def test_lists_leave_out_what_is_archived_or_deleted_unless_it_is_asked_for(service, aside, campaign) -> None:
    other = service.repository.create(CampaignRequest(name="another", rig=RIG), "Ada").id
    kept, archived, deleted = (record(service, campaign) for _ in range(3))
    before = service.repository.campaign(campaign).revision
    aside.archive("run", archived, "Ada")
    aside.delete("run", deleted, "Bob", GRACE)
    view = service.repository.campaign(campaign)
    assert (view.runs, view.revision) == ((kept,), before + 2)
    assert service.repository.runs(campaign, archived=True) == (kept, archived)
    assert service.repository.runs(campaign, archived=True, deleted=True) == (kept, archived, deleted)
    aside.archive("campaign", campaign, "Ada")
    assert [found.id for found in service.repository.campaigns(None, 9)] == [other]
    assert [found.id for found in service.repository.campaigns(None, 9, archived=True)] == [other, campaign]
    # A run that is archived or deleted with its campaign says so too.
    assert run_view(service, kept).archived_utc
    assert run_view(service, deleted).purge_utc > run_view(service, deleted).deleted_utc


def test_what_is_restored_is_as_it_was(service, aside, campaign) -> None:
    run = record(service, campaign)
    for kind, name in (("run", run), ("campaign", campaign)):
        aside.archive(kind, name, "Ada")
        aside.delete(kind, name, "Ada", GRACE)
        aside.restore(kind, name, "Ada")
    assert service.repository.campaign(campaign).runs == (run,)
    assert (run_view(service, run).deleted_utc, run_view(service, run).archived_utc) == ("", "")


def test_a_deleted_run_is_in_no_result_and_an_archived_one_where_it_is_named(service, aside, campaign) -> None:
    first, second = record(service, campaign), record(service, campaign)
    aside.archive("run", first, "Ada")
    assert order_job(service, campaign, "identify", JobRequest(), "Ada").inputs == (second,)
    assert order_job(service, campaign, "identify", JobRequest(runs=(first, second)), "Ada").inputs == (first, second)
    aside.delete("run", first, "Ada", GRACE)
    with pytest.raises(NotFoundError, match="no run"):
        order_job(service, campaign, "identify", JobRequest(runs=(first,)), "Ada")
    aside.delete("run", second, "Ada", GRACE)
    with pytest.raises(ConflictError, match="no ended, valid run"):
        export_campaign(service, campaign, "hdf5")


def test_nothing_is_added_to_a_campaign_that_is_set_aside(service, aside, campaign) -> None:
    record(service, campaign)
    aside.archive("campaign", campaign, "Ada")
    with pytest.raises(ConflictError, match="the campaign is archived"):
        order_job(service, campaign, "report", JobRequest(), "Ada")
    # But a run that was on its way brings it back rather than to be deleted with it.
    run = record(service, campaign)
    assert service.repository.campaign(campaign).archived_utc == ""
    assert run in service.repository.campaign(campaign).runs


def test_what_goes_on_or_waits_or_is_continued_is_not_deleted(service, aside, campaign) -> None:
    first = record(service, campaign)
    second = record(service, campaign, continues=first)
    with pytest.raises(ConflictError, match=f"run {second} continues this run"):
        aside.delete("run", first, "Ada", GRACE)
    aside.delete("run", second, "Ada", GRACE)
    aside.delete("run", first, "Ada", GRACE)
    item = RunQueue(service.engine).add(
        RIG, QueueItemRequest(campaign=campaign, plan=ImpactPlan(points=(1,))), 1.0, "Ada"
    )
    with pytest.raises(ConflictError, match="the queue belongs to this run"):
        aside.delete("campaign", campaign, "Ada", GRACE)
    RunQueue(service.engine).take_out(RIG, item.id, "", "Ada")
    rig = service.store.catalogue.run(first).rig
    with service.store.begin(ImpactPlan(points=(1,)), rig, BenchInfo("sim://", (), True, False, {})) as recorder:
        service.repository.add_run(RunEntry(recorder.run, campaign, RIG, "Ada", None), {})
        for kind, name in (("run", recorder.run), ("campaign", campaign)):
            with pytest.raises(ConflictError, match="is active"):
                aside.delete(kind, name, "Ada", GRACE)
            with pytest.raises(ConflictError, match="is active"):
                aside.archive(kind, name, "Ada")
        recorder.enter_state("done")


def test_samples_stay_to_the_end_of_the_grace_time_and_rows_for_good(service, aside, campaign) -> None:
    clocks = Clocks()
    purge = clocks.purge(service)
    run, kept = record(service, campaign), record(service, campaign)
    held = samples(service, run)
    aside.delete("run", run, "Ada", GRACE)
    clocks.go_on(GRACE - timedelta(minutes=1))
    purge.check_now()
    assert samples(service, run) == held
    clocks.go_on(timedelta(minutes=2))
    purge.check_now()
    with pytest.raises(StorageError, match="run deleted by Ada"):
        samples(service, run)
    with pytest.raises(ConflictError, match="its grace time ended"):
        aside.restore("run", run, "Ada")
    assert (samples(service, kept), run_view(service, run).blocks) == (held, 2)


def test_a_deleted_campaign_loses_its_samples_and_reports(service, aside, campaign) -> None:
    clocks = Clocks()
    purge = clocks.purge(service)
    run = record(service, campaign)
    report = service.folder / "results" / "one" / "report.html"
    report.parent.mkdir(parents=True)
    report.write_text("a report")
    job = order_job(service, campaign, "report", JobRequest(), "Ada")
    leases = JobLeases(service.engine, "a runner")
    (taken,) = leases.lease_jobs(["report"], 1)
    assert leases.complete(taken, {"document": {}, "files": {"report.html": "results/one/report.html"}})
    aside.delete("campaign", campaign, "Ada", GRACE)
    clocks.go_on(GRACE + timedelta(minutes=1))
    purge.check_now()
    assert not report.exists()
    with pytest.raises(StorageError, match=f"campaign {campaign} deleted by Ada"):
        samples(service, run)
    assert service.jobs.get(job.id).state == "done"


def test_a_clock_that_is_set_forward_deletes_nothing(service, aside, campaign) -> None:
    clocks = Clocks()
    purge = clocks.purge(service)
    run = record(service, campaign)
    aside.delete("run", run, "Ada", GRACE)
    clocks.day += timedelta(days=4000)
    clocks.s += 60.0
    purge.check_now()
    assert samples(service, run) > 0


def test_a_purge_that_was_broken_off_is_finished(service, aside, campaign) -> None:
    clocks = Clocks()
    purge = clocks.purge(service)
    run = record(service, campaign)
    aside.delete("run", run, "Ada", GRACE)
    clocks.go_on(GRACE + timedelta(minutes=1))
    assert aside.begin_purge("run", run, clocks.day.isoformat())
    with pytest.raises(ConflictError):
        aside.restore("run", run, "Ada")
    purge.check_now()
    with pytest.raises(StorageError, match="were deleted"):
        samples(service, run)
    assert aside.expired_entries(clocks.day.isoformat()) == []
