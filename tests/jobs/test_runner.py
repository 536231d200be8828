"""A runner with workers of its own: what is computed, rejected, interrupted and kept."""

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as NotYetError
from pathlib import Path

import psutil
import pytest
from distributed.comm.core import CommClosedError
from kinds_for_tests import kinds, secret_kind
from waiting import ended, until

from modallab.core.errors import JobError
from modallab.jobs import Jobs
from modallab.jobs.cluster import DaskCluster, SchedulerLostError, TlsFiles, check_address
from modallab.jobs.runner import JobRunner


@pytest.fixture
def runner(jobs: Jobs, tmp_path: Path) -> Iterator[JobRunner]:
    with JobRunner(jobs, [*kinds(tmp_path, spin=0.5), secret_kind()], workers=1) as started:
        yield started


def test_jobs_are_computed_by_another_process_and_their_results_kept(
    jobs: Jobs, runner: JobRunner, tmp_path: Path
) -> None:
    ordered = [jobs.submit("square", {"x": x}, ["run"]) for x in range(5)]
    done = ended(jobs, *ordered)
    assert [job.state for job in done] == ["done"] * 5
    assert [job.result["square"] for job in done] == [0, 1, 4, 9, 16]
    assert {job.result["process"] for job in done} != {os.getpid()}
    assert all((job.progress, job.attempts, job.error) == (1.0, 1, None) for job in done)
    kept = sorted(path.read_text() for path in tmp_path.glob("*-x.txt"))
    assert kept == ["0", "1", "2", "3", "4"]
    assert runner.status == "running"

    orders: list[tuple[str, dict[str, int]]] = [("reject", {"x": 3}), ("break", {}), ("no such", {}), ("secret", {})]
    rejected, broken, unknown, unsent = ended(jobs, *(jobs.submit(kind, parameters, []) for kind, parameters in orders))
    assert (rejected.state, rejected.attempts) == ("failed", 1)
    assert rejected.error == "x: x is 3\n  what to do: give another x"
    assert (broken.state, broken.error) == ("failed", "ZeroDivisionError: by nothing")
    assert (unsent.state, unsent.attempts) == ("failed", 1)
    assert "Could not serialize" in str(unsent.error)
    assert unknown.state == "failed"
    assert "no kind 'no such' is registered; there are break, die," in str(unknown.error)


def test_progress_is_seen_and_a_cancelled_job_stops_at_once(jobs: Jobs, runner: JobRunner) -> None:
    job = jobs.submit("wait", {"x": 1, "steps": 10_000}, [])
    until(lambda: jobs.get(job.id).progress > 0)
    assert 0 < jobs.get(job.id).progress < 1
    assert jobs.cancel(job.id).state == "cancelled"
    # The one worker is free again: the next job gets it.
    (after,) = ended(jobs, jobs.submit("square", {"x": 7}, []))
    assert after.state == "done"
    assert jobs.get(job.id).state == "cancelled"
    assert jobs.get(job.id).result is None


@pytest.mark.thorough("starts a scheduler and workers, and kills them")
def test_a_job_cancelled_while_it_imports_leaves_the_package_whole(
    jobs: Jobs, runner: JobRunner, tmp_path: Path
) -> None:
    package, begun = tmp_path / "slow_package", tmp_path / "begun"
    package.mkdir()
    (package / "part.py").write_text("WHOLE = True\n")
    lines = ["import pathlib, time, slow_package.part", f"pathlib.Path({str(begun)!r}).touch()"]
    lines += ["end = time.monotonic() + 1", "while time.monotonic() < end:", "    pass"]
    # Of a package of which half was imported its parts are known, but not that they are its own.
    (package / "__init__.py").write_text("\n".join([*lines, "WHOLE = slow_package.part.WHOLE"]))
    asked = {"folder": str(tmp_path), "package": "slow_package"}
    first = jobs.submit("import", asked, ["first"])
    until(begun.exists)
    jobs.cancel(first.id)
    (after,) = ended(jobs, jobs.submit("import", asked, ["second"]))
    assert (after.state, after.result) == ("done", True)


def test_what_looks_out_for_nothing_is_stopped_too_when_its_time_is_over(jobs: Jobs, runner: JobRunner) -> None:
    long, after = ended(jobs, jobs.submit("spin", {"seconds": 600}, []), jobs.submit("square", {"x": 2}, []))
    assert (long.state, long.attempts) == ("failed", 1)
    assert "exceeded 0.5 s" in str(long.error)
    assert after.state == "done"


@pytest.mark.thorough("starts a scheduler and workers, and kills them")
def test_a_job_that_kills_its_workers_is_given_up(jobs: Jobs, runner: JobRunner) -> None:
    deadly, good = ended(jobs, jobs.submit("die", {}, []), jobs.submit("square", {"x": 4}, []))
    assert (deadly.state, deadly.attempts) == ("failed", 3)
    assert "given up after 3 attempts, the last one because a worker was lost" in str(deadly.error)
    assert good.state == "done"


@pytest.mark.thorough("starts a scheduler and workers, and kills them")
def test_a_killed_scheduler_is_started_anew_and_no_job_is_lost(jobs: Jobs, tmp_path: Path) -> None:
    with JobRunner(jobs, kinds(tmp_path), workers=1) as runner:
        opened = tmp_path / "opened"
        ordered = [jobs.submit("gate", {"x": x, "file": str(opened)}, []) for x in range(2)]
        until(lambda: any(0 < jobs.get(job.id).progress < 1 for job in ordered))
        before = runner.processes
        assert set(before) == {"scheduler", "worker 0"}
        assert os.getpid() not in before.values()
        psutil.Process(before["scheduler"]).kill()
        opened.touch()
        done = ended(jobs, *ordered)
        after = runner.processes
    assert [(job.state, job.result["x"]) for job in done] == [("done", 0), ("done", 1)]
    assert sorted(job.attempts for job in done) == [1, 2]
    assert after["scheduler"] != before["scheduler"]
    until(lambda: not any(psutil.pid_exists(pid) for pid in (*before.values(), *after.values())))


@pytest.mark.thorough("starts a scheduler and workers, and kills them")
def test_who_asks_a_scheduler_that_dies_meanwhile_hears_of_it_at_once() -> None:
    with DaskCluster.connect(None, None, 0) as cluster, ThreadPoolExecutor(1) as pool:
        process = psutil.Process(cluster.processes["scheduler"])
        assert (cluster.thread_count, cluster.running_tasks) == (0, frozenset())
        process.suspend()
        asked = pool.submit(lambda: cluster.thread_count)
        with pytest.raises(NotYetError):
            asked.result(0.3)
        process.kill()
        # Dask alone would try to connect again, and say so after ten seconds.
        with pytest.raises((SchedulerLostError, CommClosedError)):
            asked.result()
        # The connection may break a moment before the process is seen to be gone.
        until(lambda: not cluster.is_alive, 5.0)


@pytest.mark.thorough("starts a scheduler and workers, and kills them")
def test_a_frozen_scheduler_is_given_up_and_ended() -> None:
    with DaskCluster.connect(None, None, 0) as cluster:
        process = psutil.Process(cluster.processes["scheduler"])
        process.suspend()
        cluster.patience_s = 0.3
        with pytest.raises(SchedulerLostError, match=r"not answered for 0\.3 s"):
            _ = cluster.thread_count
        assert not process.is_running()
        assert not cluster.is_alive


@pytest.mark.thorough("starts a scheduler and workers, and kills them")
def test_a_runner_that_stops_leaves_its_jobs_to_the_next(jobs: Jobs, tmp_path: Path) -> None:
    with JobRunner(jobs, kinds(tmp_path), workers=1):
        job = jobs.submit("wait", {"x": 1, "steps": 10_000}, [])
        until(lambda: jobs.get(job.id).progress > 0)
    left = jobs.get(job.id)
    assert (left.state, left.attempts, left.progress) == ("queued", 0, 0.0)


def test_tasks_go_to_another_machine_by_tls_only(jobs: Jobs) -> None:
    for address in ("tcp://192.0.2.7:8786", "tcp://scheduler:8786"):
        with pytest.raises(JobError, match="neither encryption nor authentication"):
            JobRunner(jobs, [], address)
    with pytest.raises(JobError, match="needs certificates"):
        JobRunner(jobs, [], "tls://scheduler:8786")
    with pytest.raises(JobError, match="no address"):
        check_address("scheduler", None)
    tls = TlsFiles(Path("ca.pem"), Path("cert.pem"), Path("key.pem"))
    check_address("tls://scheduler:8786", tls)
    check_address("tcp://127.0.0.1:8786", None)
    with pytest.raises(JobError, match=r"no such certificate file: ca\.pem"):
        tls.security()
