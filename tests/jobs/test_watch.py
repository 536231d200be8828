"""A holder that gives no sign loses its jobs, by the watcher's monotonic clock; whoever gives one keeps them."""

import threading
from collections.abc import Callable
from contextlib import suppress

import pytest
from sqlalchemy import Engine, inspect, text

from modallab.jobs import Jobs
from modallab.jobs.leases import JobLeases, LeasedJob, LeaseMarkTimer


class Clock:
    """Goes on when it is made to."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def engine(each_engine: Engine) -> Engine:
    return each_engine


def test_a_time_out_is_counted_from_the_first_look_on(clock: Clock) -> None:
    watch = LeaseMarkTimer(10.0, clock)
    clock.now_s = 100.0
    assert watch.check_now({"a": (1, 7.0)}) == {}
    for _ in range(10):
        clock.now_s += 1.0
        assert watch.check_now({"a": (1, 7.0)}) == {}
    clock.now_s += 1.0
    assert watch.check_now({"a": (1, 7.0)}) == {"a": (1, 7.0)}


def test_every_sign_and_every_new_holder_begins_anew(clock: Clock) -> None:
    watch = LeaseMarkTimer(10.0, clock)
    # Backwards is a change as well: what the number says does not matter.
    marks = [(1, 7.0), (1, 8.0), (2, 8.0), (2, 3.0)]
    for mark in marks:
        for _ in range(10):
            assert watch.check_now({"a": mark}) == {}
            clock.now_s += 1.0


def test_a_watcher_that_slept_does_not_blame_the_holder(clock: Clock) -> None:
    watch = LeaseMarkTimer(10.0, clock)
    watch.check_now({"a": (1, 1.0)})
    for _ in range(4):
        clock.now_s += 3600.0
        assert watch.check_now({"a": (1, 1.0)}) == {}


def test_a_job_that_comes_back_is_a_new_one(clock: Clock) -> None:
    watch = LeaseMarkTimer(1.0, clock)
    for held in ({"a": (1, 1.0)}, {}, {"a": (1, 1.0)}, {"a": (1, 1.0)}):
        clock.now_s += 0.9
        assert watch.check_now(held) == {}


def test_of_two_who_saw_the_same_time_out_one_takes_the_job(engine: Engine) -> None:
    job = Jobs(engine).submit("identify", {}, [])
    (dead,) = JobLeases(engine, "dead").lease_jobs(["identify"], 1)
    heirs = [JobLeases(engine, name, lease_s=0.001) for name in ("one", "two")]
    found: list[LeasedJob] = []
    barrier = threading.Barrier(len(heirs), timeout=60)

    def take(heir: JobLeases) -> None:
        for _ in range(12):
            barrier.wait()
            found.extend(heir.lease_jobs(["identify"], 1))
            if found:
                barrier.abort()

    threads = [threading.Thread(target=suppressed, args=(take, heir)) for heir in heirs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [(taken.job.id, taken.fence) for taken in found] == [(job.id, 2)]
    assert not JobLeases(engine, "dead").complete(dead, None)


def suppressed(take: Callable[[JobLeases], None], heir: JobLeases) -> None:
    with suppress(threading.BrokenBarrierError):
        take(heir)


def test_a_sign_between_the_look_and_the_taking_keeps_the_job(engine: Engine) -> None:
    Jobs(engine).submit("identify", {}, [])
    holder = JobLeases(engine, "holder")
    (taken,) = holder.lease_jobs(["identify"], 1)
    heir = JobLeases(engine, "heir", lease_s=0.01)
    for _ in range(40):
        assert holder.renew({taken.job.id: (taken.fence, 0.5, "")}) == set()
        assert heir.lease_jobs(["identify"], 1) == []
    assert holder.complete(taken, "mine")


def test_a_table_of_the_version_before_is_brought_up_to_date(engine: Engine) -> None:
    jobs = Jobs(engine)
    job = jobs.submit("identify", {"x": 1}, ["run"])
    with engine.begin() as connection:
        connection.execute(text("ALTER TABLE jobs RENAME COLUMN beat TO lease_until"))
        connection.execute(text("ALTER TABLE jobs DROP COLUMN revision"))
        connection.execute(text("UPDATE jobs SET lease_until = 1790000000.25, state = 'running', fence = 4"))
    again = Jobs(engine)
    assert "beat" in {column["name"] for column in inspect(engine).get_columns("jobs")}
    assert (again.get(job.id).parameters, again.get(job.id).revision) == ({"x": 1}, "")
    heir = JobLeases(engine, "heir", lease_s=1e-9)
    taken = next(found for _ in range(20) if (found := heir.lease_jobs(["identify"], 1)))
    assert taken[0].fence == 5
