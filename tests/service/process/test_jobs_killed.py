"""The process that has jobs computed is killed: its jobs are free at once, and done."""

import time

import psutil
import pytest
from service_process import ServiceProcess

from modallab.core.documents.results import JobView
from modallab.core.plan import ImpactPlan

PATIENCE_S = 600.0
"""On a busy machine three processes that begin one after the other, and their imports, take minutes."""


def _wait_for(service: ServiceProcess, job: str, state: str) -> JobView:
    end = time.monotonic() + PATIENCE_S
    while (view := service.client.job(job)).state != state:
        assert time.monotonic() < end, f"{view.state} instead of {state}"
    return view


@pytest.mark.thorough("kills processes of a running service")
def test_jobs_of_a_killed_process_wait_for_no_lease(service: ServiceProcess) -> None:
    lab = service.client
    campaign = lab.create_campaign("jobs killed", service.rig).id
    with lab.take_lease(service.rig, "Ada", ttl_s=300) as lease:
        run = lab.start_run(campaign, ImpactPlan(points=(10, 3), hits=2), lease).id
        list(lab.follow_run(run))
    job = lab.order_job(campaign, "identify", band_hz=[2.0, 401.0]).id
    _wait_for(service, job, "running")
    killed = lab.processes()["jobs"]
    psutil.Process(killed).kill()
    # Another that took it over for the holder's time-out would never let it be seen in the queue.
    assert _wait_for(service, job, "queued").attempts == 1
    done = _wait_for(service, job, "done")
    assert done.attempts == 2
    assert lab.processes()["jobs"] != killed
