"""Whatever process is killed, at whatever moment: what was acknowledged is there, nothing is stuck, work goes on."""

import os
import random
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import httpx
import pytest
from kept import Follower, require_kept
from service_process import ServiceProcess

from modallab.acquisition.process.trip import TripLatch
from modallab.client import ServiceProblemError
from modallab.core.documents.runs import StopRun
from modallab.core.plan import ImpactPlan, SinePlan

LONG = ImpactPlan(points=(10, 6, 3), hits=200)
DRIVEN = SinePlan(frequencies_hz=tuple(19.0 + n for n in range(40)), settle_s=2.0, ramp_s=0.5, wait_s=1.0)
AGAIN = pytest.mark.thorough("kills processes of a running service")
QUICK_BEAM = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"


def wait_until(happened: Callable[[], object], within_s: float = 240.0) -> None:
    end = time.monotonic() + within_s
    while not happened():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.05)


def kill(service: ServiceProcess, name: str) -> None:
    os.kill(service.client.processes()[name], signal.SIGKILL)


@AGAIN
@pytest.mark.parametrize("victim", ["api", "rig"])
def test_a_killed_process_costs_nothing_that_was_acknowledged(tmp_path: Path, victim: str) -> None:
    with ServiceProcess(tmp_path / "data", "--no-jobs", bench=QUICK_BEAM) as service:
        lab = service.client
        follower = Follower(service.url, service.token)
        campaign = lab.create_campaign("killed", service.rig)
        with lab.take_lease(service.rig, "Ada", ttl_s=300) as lease:
            run = lab.start_run(campaign.id, LONG, lease).id
            wait_until(lambda: len(follower.acknowledged) > 2)
            time.sleep(random.Random(1).uniform(0, 0.3))
            kill(service, "api" if victim == "api" else f"rig {service.rig}")
            if victim == "rig":
                wait_until(lambda: service.client.run(run).state == "failed")
                lab.wait_until_idle(service.rig)
                # After a hit nothing is driven, so nothing is latched: it goes on with what is left.
                second = lab.start_run(campaign.id, None, lease, continues=run).id
                wait_until(lambda: any(e.run == second and e.kind == "block" for e in follower.events))
                run = second
            else:
                before = len(follower.acknowledged)
                wait_until(lambda: len(follower.acknowledged) > before + 2)
            wait_until(lambda: _stopped(service, run, lease))
        require_kept(lab, follower.acknowledged)
        seen = [event.seq for event in follower.events]
        assert seen == list(range(1, len(seen) + 1))


def _stopped(service: ServiceProcess, run: str, lease) -> bool:
    if service.client.run(run).state == "acquiring":
        with suppress(ServiceProblemError):
            service.client.command_run(run, StopRun(), lease)
    return service.client.run(run).state == "done"


@AGAIN
def test_the_services_own_death_leaves_a_failed_run_with_its_blocks(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with ServiceProcess(data, "--no-jobs", bench=QUICK_BEAM) as service:
        lab = service.client
        follower = Follower(service.url, service.token)
        campaign = lab.create_campaign("killed", service.rig)
        lease = lab.take_lease(service.rig, "Ada", ttl_s=300)
        run = lab.start_run(campaign.id, LONG, lease).id
        wait_until(lambda: len(follower.acknowledged) > 2)
        service.process.kill()
        service.process.wait()
        acknowledged = follower.acknowledged
    with ServiceProcess(data, "--no-jobs", bench=QUICK_BEAM) as again:
        wait_until(lambda: again.client.run(run).state == "failed")
        view = again.client.run(run)
        assert "interrupted" in view.reason
        assert view.valid
        require_kept(again.client, acknowledged)


@pytest.mark.parametrize(
    "found_by", ["the stop listener", pytest.param("no heartbeat of the REST process", marks=AGAIN)]
)
def test_a_frozen_rest_process_keeps_nobody_from_stopping(tmp_path: Path, found_by: str) -> None:
    by_hand = found_by == "the stop listener"
    bench, env = f"{QUICK_BEAM}&pace=1", {"MODALLAB_HEARTBEAT_TIMEOUT_S": "60" if by_hand else "1"}
    with ServiceProcess(tmp_path / "data", "--no-jobs", bench=bench, env=env) as service:
        lab = service.client
        campaign = lab.create_campaign("frozen", service.rig)
        with lab.take_lease(service.rig, "Ada", ttl_s=300) as lease:
            run = lab.start_run(campaign.id, DRIVEN, lease).id
            wait_until(lambda: lab.run(run).state == "acquiring")
            api = lab.processes()["api"]
            os.kill(api, signal.SIGSTOP)
            try:
                if by_hand:
                    assert httpx.post(service.stop_url, timeout=60.0).json() == {"stopped": [service.rig]}
                latch = TripLatch(tmp_path / "data", bench)
                wait_until(lambda: latch.read() is not None)
                trip = latch.read()
            finally:
                os.kill(api, signal.SIGCONT)
            assert trip is not None
            assert found_by in trip.what
            wait_until(lambda: lab.run(run).state == "aborted")
            assert lab.processes()["api"] == api


@AGAIN
def test_when_the_rest_process_is_gone_what_is_driven_is_stopped_and_latched(tmp_path: Path) -> None:
    with ServiceProcess(tmp_path / "data", "--no-jobs", bench=f"{QUICK_BEAM}&pace=1") as service:
        lab = service.client
        campaign = lab.create_campaign("driven", service.rig)
        with lab.take_lease(service.rig, "Ada", ttl_s=300) as lease:
            run = lab.start_run(campaign.id, DRIVEN, lease).id
            wait_until(lambda: lab.run(run).state == "acquiring")
            os.kill(lab.processes()["api"], signal.SIGKILL)
            wait_until(lambda: service.client.run(run).state == "aborted")
            trip = lab.rig(service.rig).trip
            assert trip is not None
            assert "REST process" in trip.reason
            with pytest.raises(ServiceProblemError, match="tripped"):
                lab.start_run(campaign.id, DRIVEN, lease)
            lab.reset_rig(service.rig, lease, "looked at it")
            assert lab.rig(service.rig).trip is None
