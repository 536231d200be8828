"""A service that is asked to end leaves at once, and says of the run that was on that it is not whole."""

import os
import signal
import time
from pathlib import Path

import pytest
from service_process import ServiceProcess

from modallab.core.plan import ImpactPlan, SinePlan
from modallab.service.records.repository import CampaignRepository
from modallab.storage import Store

HITS = ImpactPlan(points=(10, 6, 3), hits=2000)
DRIVEN = SinePlan(frequencies_hz=tuple(19.0 + n for n in range(40)), settle_s=0.5, ramp_s=0.25, wait_s=0.5)
BENCH = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"
LEAVE_S = 9.0
"""3 s on a machine that does nothing else."""


@pytest.mark.thorough("starts a service, and ends it in a run")
@pytest.mark.parametrize(
    ("plan", "asked_by"),
    [pytest.param(HITS, signal.SIGTERM, id="impact, SIGTERM"), pytest.param(DRIVEN, signal.SIGINT, id="sine, Ctrl-C")],
)
def test_a_run_that_is_cut_short_by_the_end_of_the_service_has_failed(tmp_path: Path, plan, asked_by) -> None:
    # A shell has what it runs in the background ignore Ctrl-C, and whatever that starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with ServiceProcess(tmp_path / "data", "--workers", "1", bench=BENCH, start_new_session=True) as service:
        lab = service.client
        campaign = lab.create_campaign("ended", service.rig)
        with_lease = lab.take_lease(service.rig, "Ada", ttl_s=300)
        run = lab.start_run(campaign.id, plan, with_lease).id
        while not lab.run(run).blocks:
            time.sleep(0.05)
        began = time.monotonic()
        if asked_by == signal.SIGINT:
            # A terminal sends it to all processes.
            os.killpg(service.process.pid, asked_by)
        else:
            service.process.send_signal(asked_by)
        service.process.wait(120)
        took_s = time.monotonic() - began
        log = service.log
    with Store(tmp_path / "data") as store:
        record = store.catalogue.run(run)
        assert (record.state, record.valid) == ("failed", True), log
        assert record.reason == "interrupted: the service was ended"
        assert len(store.blocks(run)) > 0
        entry = CampaignRepository(store.catalogue.engine).run_entry(run)
        assert entry is not None
        assert entry.code == "interrupted"
    assert not (tmp_path / "data" / "trip").exists()
    assert took_s < LEAVE_S, log
    assert '"level": "ERROR"' not in log
