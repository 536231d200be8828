"""A real PostgreSQL server is stopped under the service, and started again: it says so, and goes on by itself."""

import time
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest
from postgresql_server import postgresql_server
from service_process import ServiceProcess

from modallab.core.plan import ImpactPlan

pytestmark = pytest.mark.thorough("starts a PostgreSQL server, and stops it")

BENCH = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"


def wait_until(happened: Callable[[], object], within_s: float = 120.0) -> float:
    began = time.monotonic()
    while not happened():
        assert time.monotonic() - began < within_s, "not in time"
        time.sleep(0.05)
    return time.monotonic() - began


def test_the_service_names_the_database_meanwhile_and_its_jobs_go_on(tmp_path: Path) -> None:
    with (
        postgresql_server() as server,
        ServiceProcess(
            tmp_path / "data", "--workers", "1", bench=BENCH, env={"MODALLAB_DATABASE": server.new_database()}
        ) as service,
    ):
        lab = service.client
        campaign = lab.create_campaign("on a server", service.rig)
        with lab.take_lease(service.rig, "Ada", ttl_s=600) as lease:
            run = lab.start_run(campaign.id, ImpactPlan(points=(10, 6, 3), hits=2), lease).id
            wait_until(lambda: lab.run(run).state == "done")
            wait_until(lambda: lab.jobs(campaign.id))
            first = lab.jobs(campaign.id)[0].id
            wait_until(lambda: lab.job(first).state == "done", 240.0)
            # Another band is another work.
            job = lab.order_job(campaign.id, "identify", band_hz=[2.0, 400.0]).id
            wait_until(lambda: lab.job(job).state == "running")
            server.stop()
            wait_until(lambda: health(service)["status"] == "degraded", 10.0)
            (trouble,) = health(service)["troubles"]
            assert trouble["part"] == "database"
            assert trouble["since_utc"]
            assert "server" in trouble["remedy"]
            lost = httpx.get(f"{service.url}/api/v1/jobs", headers={"Authorization": f"Bearer {service.token}"})
            assert (lost.status_code, lost.json()["code"]) == (503, "database-lost")
            # The emergency stop needs no database.
            assert httpx.post(service.stop_url, timeout=5.0).json() == {"stopped": [service.rig]}
            server.start()
            wait_until(lambda: health(service)["status"] == "good", 15.0)
            wait_until(lambda: lab.job(job).state == "done", 60.0)
            assert lab.job(job).error is None
            wait_until(lambda: [event for event in events(service) if event["kind"] == "tripped"], 15.0)
            lab.reset_rig(service.rig, lease)


def health(service: ServiceProcess) -> dict:
    return httpx.get(f"{service.url}/health", timeout=5.0).json()


def events(service: ServiceProcess) -> list[dict]:
    headers = {"Authorization": f"Bearer {service.token}"}
    return httpx.get(f"{service.url}/api/v1/events", headers=headers, params={"limit": 500}).json()["items"]
