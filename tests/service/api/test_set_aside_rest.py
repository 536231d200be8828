"""Archive, delete and restore, by the client."""

import pytest
from lab import RIG, TOKEN, Lab

from modallab.client import Client, ServiceProblemError
from modallab.core.documents.runs import RunRequest, StopRun
from modallab.core.plan import ImpactPlan
from modallab.service.campaigns.run_start import begin_run


def test_a_run_and_its_campaign_go_and_come_back(lab: Lab) -> None:
    campaign, lease = lab.campaign(), lab.lease()
    run = begin_run(lab.service, campaign, RunRequest(plan=ImpactPlan(points=(10,), hits=40)), lease.id)
    with Client(lab.url, TOKEN, "Ada") as client:
        lab.wait_for(lambda e: e.run == run and e.kind == "block")
        for deleted in (client.delete_run, client.archive_run):
            with pytest.raises(ServiceProblemError, match="is active"):
                deleted(run)
        with pytest.raises(ServiceProblemError, match="is active"):
            client.delete_campaign(campaign)
        lab.controllers.command(RIG, run, StopRun(), lease.id)
        lab.wait_for_ended(run)
        lab.wait_until_idle()
        gone = client.delete_run(run)
        # Asked again, as after an answer that was lost, the grace time does not begin again.
        assert client.delete_run(run).purge_utc == gone.purge_utc > gone.deleted_utc
        assert (client.runs(campaign), client.campaign(campaign).runs) == ((), ())
        assert [found.id for found in client.runs(campaign, deleted=True)] == [run]
        assert client.samples(run, 0).size > 0
        assert client.restore_run(run).deleted_utc == ""
        archived = client.archive_campaign(campaign)
        assert archived.archived_utc
        assert campaign not in {found.id for found in client.campaigns()}
        assert campaign in {found.id for found in client.campaigns(archived=True)}
        with pytest.raises(ServiceProblemError, match="restore it first"):
            client.order_job(campaign, "identify")
        assert client.delete_campaign(campaign).deleted_utc
        assert client.restore_campaign(campaign).runs == (run,)
        with pytest.raises(ServiceProblemError, match="there is no run"):
            client.delete_run("none")
    kinds = [e.content["state"] for e in lab.events("set_aside")]
    assert kinds[-3:] == ["archived", "deleted", "restored"]
    lab.service.leases.release(RIG, lease.id)
