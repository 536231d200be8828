"""A session at the bench through the real service: campaign, run, blocks, FRF, model."""

import numpy as np
import pytest
from service_process import ServiceProcess

from modallab.core.plan import ImpactPlan
from modallab.storage import Store

TRUE_HZ = (4.754972, 30.594413, 87.1533545)


@pytest.mark.thorough("records and identifies through a service of its own")
def test_an_impact_run_ends_with_a_model_of_the_true_modes(service: ServiceProcess) -> None:
    lab = service.client
    campaign = lab.create_campaign("a session", service.rig)
    with lab.take_lease(service.rig, "Ada") as lease:
        run = lab.start_run(campaign.id, ImpactPlan(points=(10, 3), hits=2), lease)
        events = list(lab.follow_run(run.id))
    assert [e.content["state"] for e in events if e.kind == "state"] == [
        "created", "arming", "armed", "acquiring", "processing", "done",
    ]  # fmt: skip
    assert [e.seq for e in events] == sorted({e.seq for e in events})
    acknowledged = {e.content["n"]: e.content["crc32"] for e in events if e.kind == "block"}
    assert {b.n: b.crc32 for b in lab.blocks(run.id)} == acknowledged
    with Store(service.data) as store:
        kept = store.blocks(run.id, rejected=True)
        for block, n in zip(kept, acknowledged, strict=True):
            np.testing.assert_array_equal(lab.samples(run.id, n), block.samples)
    frf = lab.frf(run.id)
    assert frf.values.shape == (10, 2, frf.frequency_hz.size)
    assert frf.coherence is not None
    assert np.nanmedian(frf.coherence) > 0.95
    (job,) = lab.jobs(campaign.id, "identify")
    done = lab.wait_for_job(job.id)
    assert done.state == "done", done.error
    (model,) = done.result["document"]["models"]
    np.testing.assert_allclose(model["frequency_hz"][:3], TRUE_HZ, rtol=1e-4)
