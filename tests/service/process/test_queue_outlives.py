"""A queue of runs outlives the REST process and the service, and starts no shaker when it wakes up; and `--open`."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest
from pages import ROOT, fenced
from service_process import ServiceProcess

from modallab.cli.demo import demo_rig
from modallab.core.documents.queue import QueueItem
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.formats.rig.rig_file import write_rig

pytestmark = pytest.mark.thorough("kills processes of a running service")

BENCH = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"
HIT = ImpactPlan(points=(10,), hits=1)
LONG = ImpactPlan(points=(10,), hits=15)
SINE = SinePlan(frequencies_hz=(19.53125,), settle_s=2.0, ramp_s=0.5, wait_s=1.0, levels_v={"low": 0.3})


def until(happened: Callable[[], bool], within_s: float = 240.0) -> None:
    end = time.monotonic() + within_s
    while True:
        try:
            if happened():
                return
        except httpx.TransportError:
            pass
        assert time.monotonic() < end
        time.sleep(0.05)


def items(service: ServiceProcess) -> dict[str, QueueItem]:
    return {item.id: item for item in service.client.queue(service.rig, ended=True).items}


def log_in(service: ServiceProcess) -> str:
    """Who the browser is that `--open` opens; the link works once."""
    (line,) = (line for line in service.said if line.startswith("log in once:"))
    link = line.split()[-1]
    with httpx.Client() as browser, httpx.Client() as thief:
        assert browser.get(link).status_code == 303
        assert thief.get(link).status_code == 401
        return browser.get(f"{service.url}/api/v1/me").json()["role"]


def options(rig_file: Path) -> list[str]:
    """What docs/how-to/use-the-page.md says to start, without the folder, which the helper names."""
    (command,) = (b.lines[0] for b in fenced(ROOT / "docs/how-to/use-the-page.md") if b.language == "sh")
    assert command == "modallab serve --rig rig.yaml --data lab-data --open"
    return ["--rig", str(rig_file), "--open"]


def test_a_queue_outlives_every_process_and_a_consent_only_that_of_rest(tmp_path: Path) -> None:
    no_browser = {"BROWSER": "true"}
    rig_file = tmp_path / "rig.yaml"
    write_rig(demo_rig().model_copy(update={"bench": BENCH}), rig_file)
    with ServiceProcess(tmp_path / "lab-data", "--no-jobs", *options(rig_file), env=no_browser) as service:
        assert log_in(service) == "admin"
        client, rig = service.client, service.rig
        campaign = client.create_campaign("queued", rig).id
        lease = client.take_lease(rig, "Ada", ttl_s=3600.0)
        first, second = (client.queue_run(rig, campaign, plan).id for plan in (LONG, HIT))
        client.give_consent(rig, lease, at_bench=True)
        until(lambda: items(service)[first].run != "")
        os.kill(client.processes()["api"], signal.SIGKILL)
        until(lambda: items(service)[second].state == "done")
        assert items(service)[first].state == "done"
        third, fourth = (client.queue_run(rig, campaign, plan).id for plan in (LONG, SINE))
        client.give_consent(rig, lease, at_bench=True, drive=True)
        until(lambda: items(service)[third].run != "")
        service.process.kill()
        service.process.wait()
    with ServiceProcess(tmp_path / "lab-data", "--no-jobs", "--rig", str(rig_file)) as service:
        client = service.client
        until(lambda: items(service)[third].state == "failed")
        view = client.queue(service.rig)
        assert (view.paused, "interrupted" in view.reason, view.consent) == (True, True, None)
        assert [item.id for item in view.items] == [fourth]
        with client.take_lease(service.rig, "Ada") as lease:
            resumed = client.resume_queue(service.rig, lease)
            assert (resumed.paused, "no holder of the lease has consented" in resumed.waits_for) == (False, True)
            client.give_consent(service.rig, lease, drive=True)
            until(lambda: items(service)[fourth].state == "done")
        assert len(client.campaign(campaign).runs) == 4
