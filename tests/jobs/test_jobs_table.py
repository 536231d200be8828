"""The table of jobs: what is the same job, who holds it, and that none waits for ever."""

import threading
import time
from pathlib import Path

import pytest
from sqlalchemy import Engine, text

from modallab.core.errors import JobError, UnknownJobError
from modallab.jobs import Jobs
from modallab.jobs.leases import MAX_ATTEMPTS, JobLeases, LeasedJob
from modallab.jobs.table import make_table
from modallab.storage.engine import open_engine

KINDS = ("identify",)


@pytest.fixture
def engine(each_engine: Engine) -> Engine:
    return each_engine


def _take(engine: Engine, owner: str = "one") -> LeasedJob:
    (taken,) = JobLeases(engine, owner).lease_jobs(KINDS, 1)
    return taken


def _take_over(engine: Engine, owner: str) -> list[LeasedJob]:
    """What one takes who hears no sign of the holders for a while: five looks count at most one lease."""
    leases = JobLeases(engine, owner, lease_s=0.01)
    for _ in range(6):
        assert leases.lease_jobs(KINDS, 1) == []
        time.sleep(0.004)
    return leases.lease_jobs(KINDS, 1)


def test_the_same_work_is_one_job_until_it_fails(jobs: Jobs, engine: Engine) -> None:
    first = jobs.submit("identify", {"a": 1, "b": [2]}, ["run"])
    assert (first.state, first.progress, first.attempts, first.result) == ("queued", 0.0, 0, None)
    assert jobs.submit("identify", {"b": [2], "a": 1}, ["run"]) == first
    others = [("identify", {"a": 1, "b": [3]}, ["run"]), ("diagnose", {"a": 1, "b": [2]}, ["run"])]
    others.append(("identify", {"a": 1, "b": [2]}, ["run", "other"]))
    assert len({first.id, *(jobs.submit(*other).id for other in others)}) == 4

    leases = JobLeases(engine, "one")
    (taken,) = leases.lease_jobs(("identify", "diagnose"), 1)
    assert jobs.submit("identify", {"a": 1, "b": [2]}, ["run"]).state == "running"
    assert leases.complete(taken, {"modes": 3})
    again = jobs.submit("identify", {"a": 1, "b": [2]}, ["run"])
    assert (again.id, again.state, again.result) == (first.id, "done", {"modes": 3})


def test_what_failed_or_was_cancelled_may_be_ordered_again(jobs: Jobs, engine: Engine) -> None:
    first = jobs.submit("identify", {}, [])
    JobLeases(engine, "one").fail(_take(engine), "no modes")
    second = jobs.submit("identify", {}, [])
    assert jobs.cancel(second.id).state == "cancelled"
    third = jobs.submit("identify", {}, [])
    assert len({first.id, second.id, third.id}) == 3
    assert (jobs.get(first.id).error, third.state) == ("no modes", "queued")


def test_many_who_order_the_same_at_once_get_one_job(jobs: Jobs) -> None:
    ids: list[str] = []
    barrier = threading.Barrier(8, timeout=60)

    def order() -> None:
        barrier.wait()
        ids.append(jobs.submit("identify", {"x": 1}, []).id)

    threads = [threading.Thread(target=order) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(ids) == 8
    assert len(set(ids)) == 1


def test_a_result_that_is_no_more_requested_is_not_taken(jobs: Jobs, engine: Engine) -> None:
    job = jobs.submit("identify", {}, [])
    leases, taken = JobLeases(engine, "one"), _take(engine)
    assert leases.renew({job.id: (taken.fence, 0.25, "fitting")}) == set()
    assert jobs.get(job.id).progress == 0.25
    jobs.cancel(job.id)
    assert leases.renew({job.id: (taken.fence, 0.5, "")}) == {job.id}
    assert not leases.complete(taken, 1)
    assert not leases.give_back(taken, "", counts=True)
    assert (jobs.get(job.id).state, jobs.get(job.id).result) == ("cancelled", None)
    assert jobs.cancel(job.id).state == "cancelled"


def test_the_jobs_of_a_dead_runner_are_taken_by_another_and_the_fence_keeps_the_dead_out(
    jobs: Jobs, engine: Engine
) -> None:
    job = jobs.submit("identify", {}, [])
    dead = _take(engine, "dead")
    assert JobLeases(engine, "heir").lease_jobs(KINDS, 1) == []
    (heir,) = _take_over(engine, "heir")
    assert (heir.fence, heir.job.attempts, heir.attempt_name != dead.attempt_name) == (2, 2, True)
    assert not JobLeases(engine, "dead").complete(dead, "late")
    assert JobLeases(engine, "heir").complete(heir, "good")
    assert jobs.get(job.id).result == "good"


def test_attempts_run_out(jobs: Jobs, engine: Engine) -> None:
    abandoned = jobs.submit("identify", {"x": 1}, [])
    assert _take(engine).job.attempts == 1
    for attempt in range(2, MAX_ATTEMPTS + 1):
        assert [taken.job.attempts for taken in _take_over(engine, "one")] == [attempt]
    assert _take_over(engine, "one") == []
    assert jobs.get(abandoned.id).state == "failed"
    assert "given up after 3 attempts" in str(jobs.get(abandoned.id).error)

    given_back = jobs.submit("identify", {"x": 2}, [])
    for _ in range(MAX_ATTEMPTS):
        JobLeases(engine, "one").give_back(_take(engine), "a worker was lost", counts=True)
    assert "because a worker was lost" in str(jobs.get(given_back.id).error)


def test_an_orderly_stop_is_no_attempt(jobs: Jobs, engine: Engine) -> None:
    job = jobs.submit("identify", {}, [])
    for _ in range(2 * MAX_ATTEMPTS):
        JobLeases(engine, "one").give_back(_take(engine), "stopped", counts=False)
    assert (jobs.get(job.id).state, jobs.get(job.id).attempts) == ("queued", 0)


def test_the_oldest_is_taken_first_and_what_nobody_knows_fails(jobs: Jobs, engine: Engine) -> None:
    unknown = jobs.submit("dance", {}, [])
    ids = [jobs.submit("identify", {"x": x}, []).id for x in range(3)]
    taken = JobLeases(engine, "one").lease_jobs(KINDS, 3)
    assert [t.job.id for t in taken] == ids[:2]
    assert jobs.get(unknown.id).error == "no kind 'dance' is registered; there are identify"


def test_pages_hold_every_job_once_the_newest_first(jobs: Jobs, engine: Engine) -> None:
    ids = [jobs.submit("identify", {"x": x}, []).id for x in range(7)]
    seen: list[str] = []
    cursor = None
    while True:
        page = jobs.list(cursor=cursor, limit=3)
        seen += [job.id for job in page.jobs]
        jobs.submit("report", {"since": len(seen)}, [])
        if page.cursor is None:
            break
        cursor = page.cursor
    assert seen == ids[::-1]
    assert len(jobs.list(kind="report").jobs) == 3
    _take(engine)
    assert [job.id for job in jobs.list(state="running").jobs] == ids[:1]
    for wrong in ("x", "-1", "٣"):
        with pytest.raises(JobError, match="no cursor"):
            jobs.list(cursor=wrong)
    with pytest.raises(JobError, match="0 jobs"):
        jobs.list(limit=0)


def test_what_cannot_be_kept_or_found_is_reported(jobs: Jobs) -> None:
    for bad in (float("nan"), float("inf"), {1, 2}):
        with pytest.raises(JobError, match="cannot be kept"):
            jobs.submit("identify", {"x": bad}, [])
    with pytest.raises(UnknownJobError, match="there is no job 'x'"):
        jobs.get("x")
    with pytest.raises(UnknownJobError):
        jobs.cancel("x")


def test_the_jobs_of_a_runner_that_is_known_to_be_dead_are_free_at_once(jobs: Jobs, engine: Engine) -> None:
    first, second = (jobs.submit("identify", {"n": n}, []) for n in range(2))
    held, other = _take(engine, "dead"), _take(engine, "alive")
    assert jobs.release("dead") == 1
    assert [jobs.get(job.id).state for job in (first, second)] == ["queued", "running"]
    again = _take(engine, "next")
    assert (again.job.id, again.job.attempts) == (first.id, 2)
    # What the dead one might still bring is another's job now, also under its own name.
    assert not JobLeases(engine, "dead").complete(held, {})
    assert JobLeases(engine, "next").complete(again, {"modes": 3})
    assert JobLeases(engine, "alive").complete(other, {})
    assert jobs.release("dead") == 0


def test_a_job_whose_runners_die_again_and_again_is_given_up(jobs: Jobs, engine: Engine) -> None:
    job = jobs.submit("identify", {}, [])
    for n in range(MAX_ATTEMPTS):
        assert jobs.get(job.id).attempts == n
        _take(engine)
        assert jobs.release("one") == 1
    assert JobLeases(engine, "one").lease_jobs(KINDS, 1) == []
    assert "given up after 3 attempts, the last one because its runner ended" in str(jobs.get(job.id).error)


def test_what_somebody_waits_for_goes_before_what_is_done_by_itself(jobs: Jobs, engine: Engine) -> None:
    automatic = [jobs.submit("identify", {"n": n}, ["run"], automatic=True) for n in range(3)]
    ordered = jobs.submit("report", {}, ["run"])
    # Who orders what waits already waits for it, too.
    assert jobs.submit("identify", {"n": 2}, ["run"]).id == automatic[2].id
    taken = JobLeases(engine, "one").lease_jobs(("identify", "report"), 10)
    assert [one.job.id for one in taken] == [automatic[2].id, ordered.id, automatic[0].id, automatic[1].id]


def test_a_newer_automatic_job_makes_those_idle_that_do_less(jobs: Jobs) -> None:
    first = jobs.submit("identify", {}, ["a"], automatic=True)
    ordered = jobs.submit("identify", {"x": 1}, ["a"])
    other = jobs.submit("identify", {}, ["b"], automatic=True)
    newer = jobs.submit("identify", {}, ["a", "c"], automatic=True)
    assert jobs.supersede(newer) == 1
    states = {job.id: job.state for job in jobs.list().jobs}
    assert states == {first.id: "cancelled", ordered.id: "queued", other.id: "queued", newer.id: "queued"}
    assert newer.id in str(jobs.get(first.id).error)


def test_lists_come_without_results(jobs: Jobs, engine: Engine) -> None:
    job = jobs.submit("identify", {}, ["run"])
    assert JobLeases(engine, "one").complete(_take(engine), {"modes": 3})
    assert [(one.id, one.state, one.result) for one in jobs.list().jobs] == [(job.id, "done", None)]
    assert jobs.get(job.id).result == {"modes": 3}


def test_a_table_of_an_older_program_gets_what_it_lacks(tmp_path: Path) -> None:
    engine = open_engine(f"sqlite:///{tmp_path / 'old.sqlite'}")
    make_table(engine)
    with engine.begin() as connection:
        connection.execute(text("ALTER TABLE jobs DROP COLUMN priority"))
    jobs = Jobs(engine)
    assert jobs.submit("identify", {}, ["run"]).state == "queued"
    assert len(JobLeases(engine, "one").lease_jobs(KINDS, 1)) == 1
