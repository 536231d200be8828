"""Workers and schedulers on other machines, and runners, killed in the middle: every job ends right."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import trustme
from dask_machines import HERE, Machines, machines
from kinds_for_tests import kinds
from sqlalchemy import Engine
from waiting import ended, until

from modallab.core.errors import JobError
from modallab.jobs import Jobs
from modallab.jobs.cluster import TlsFiles
from modallab.jobs.runner import JobRunner

pytestmark = pytest.mark.thorough("starts schedulers and workers, and kills them")


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Machines]:
    with machines(tmp_path) as started:
        started.scheduler()
        yield started


def test_two_workers_share_the_jobs_and_one_is_killed(jobs: Jobs, lab: Machines, tmp_path: Path) -> None:
    lab.worker()
    victim = lab.worker()
    with JobRunner(jobs, kinds(tmp_path), lab.address):
        both = ended(jobs, *(jobs.submit("wait", {"x": x, "steps": 40}, []) for x in range(4)))
        assert len({job.result["process"] for job in both}) == 2
        ordered = [jobs.submit("wait", {"x": x, "steps": 75}, []) for x in range(6)]
        until(lambda: sum(jobs.get(job.id).progress > 0 for job in ordered) >= 2)
        victim.kill()
        done = ended(jobs, *ordered)
    assert [job.state for job in done] == ["done"] * 6
    assert [job.result["x"] for job in done] == list(range(6))
    assert {job.result["process"] for job in done[2:]} <= {job.result["process"] for job in both} - {victim.pid}


def test_a_killed_scheduler_costs_time_and_no_job(jobs: Jobs, lab: Machines, tmp_path: Path) -> None:
    lab.worker()
    with JobRunner(jobs, kinds(tmp_path), lab.address) as runner:
        opened = tmp_path / "opened"
        ordered = [jobs.submit("gate", {"x": x, "file": str(opened)}, []) for x in range(3)]
        until(lambda: any(0 < jobs.get(job.id).progress < 1 for job in ordered))
        lab.end()
        opened.touch()
        until(lambda: runner.status == "connecting")
        port = int(lab.address.rpartition(":")[2])
        lab.scheduler(port)
        lab.worker()
        done = ended(jobs, *ordered)
    assert [(job.state, job.result["x"]) for job in done] == [("done", x) for x in range(3)]
    assert max(job.attempts for job in done) == 2


def test_the_jobs_of_a_killed_runner_are_taken_by_another(
    jobs: Jobs, engine: Engine, lab: Machines, tmp_path: Path
) -> None:
    lab.worker()
    url = engine.url.render_as_string(hide_password=False)
    script = str(Path(HERE) / "runner_process.py")
    doomed = subprocess.Popen([sys.executable, script, url, lab.address, str(tmp_path), "2"], env=dict(os.environ))
    try:
        job = jobs.submit("gate", {"x": 5, "file": str(tmp_path / "opened")}, [])
        until(lambda: jobs.get(job.id).progress > 0)
    finally:
        doomed.kill()
        doomed.wait(10)
    assert jobs.get(job.id).state == "running"
    (tmp_path / "opened").touch()
    with JobRunner(jobs, kinds(tmp_path), lab.address, lease_s=2.0):
        (done,) = ended(jobs, job)
    assert (done.state, done.attempts, done.result["x"]) == ("done", 2, 5)


def test_machines_with_certificates_of_one_authority_talk_and_others_do_not(jobs: Jobs, tmp_path: Path) -> None:
    good, foreign = _certificates(tmp_path / "good"), _certificates(tmp_path / "foreign")
    files = ["--tls-ca-file", str(good.ca), "--tls-cert", str(good.cert), "--tls-key", str(good.key)]
    with machines(tmp_path, files) as lab:
        lab.scheduler()
        lab.worker()
        assert lab.address.startswith("tls://")
        with pytest.raises(JobError, match="needs certificates"):
            JobRunner(jobs, kinds(tmp_path), lab.address)
        job = jobs.submit("square", {"x": 12}, [])
        with JobRunner(jobs, kinds(tmp_path), lab.address, tls=foreign) as outsider:
            until(lambda: bool(outsider.trouble))
        assert jobs.get(job.id).state == "queued"
        with JobRunner(jobs, kinds(tmp_path), lab.address, tls=good):
            (done,) = ended(jobs, job)
    assert done.result["square"] == 144


def _certificates(folder: Path) -> TlsFiles:
    folder.mkdir()
    authority = trustme.CA()
    own = authority.issue_cert("127.0.0.1", "localhost")
    tls = TlsFiles(folder / "ca.pem", folder / "cert.pem", folder / "key.pem")
    authority.cert_pem.write_to_path(str(tls.ca))
    own.private_key_pem.write_to_path(str(tls.key))
    for n, blob in enumerate(own.cert_chain_pems):
        blob.write_to_path(str(tls.cert), append=n > 0)
    return tls
