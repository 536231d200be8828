"""The client beside the service itself."""

from collections.abc import Iterator

import pytest
from lab import RIG, TOKEN, Lab

from modallab.client import Client, ServiceProblemError
from modallab.core.documents.runs import BlockVerdict, StopRun
from modallab.core.plan import ImpactPlan


@pytest.fixture
def client(lab: Lab) -> Iterator[Client]:
    with Client(lab.url, TOKEN, "Ada", timeout_s=60.0) as opened:
        yield opened


def test_lists_are_read_to_their_end(client: Client) -> None:
    made = [client.create_campaign(f"n{n}", RIG, "a note").id for n in range(53)]
    listed = [campaign.id for campaign in client.campaigns()]
    assert len(listed) == len(set(listed))
    assert set(made) <= set(listed)
    assert client.campaign(made[0]).operator == "Ada"


def test_a_session_by_the_client_alone(client: Client) -> None:
    assert client.wait_until_idle(RIG, 240.0).can_drive
    campaign = client.create_campaign("session", RIG).id
    with client.take_lease(RIG, "Ada", ttl_s=600) as lease:
        run = client.start_run(campaign, ImpactPlan(points=(10, 3), hits=2), lease).id
        states = [event.content["state"] for event in client.follow_run(run) if event.kind == "state"]
        assert states[-1] == "done"
        blocks = client.blocks(run)
        assert [client.samples(run, block.n).shape[1] for block in blocks] == [block.count for block in blocks]
        assert client.frf(run).averages == (2, 2)
        rejected = client.judge_block(run, 0, BlockVerdict(accepted=False, reason="beside the point"), lease)
        assert (rejected.accepted, client.frf(run).averages) == (False, (1, 2))
        with pytest.raises(ServiceProblemError, match="what to do") as reported:
            client.command_run(run, StopRun(), lease)
        assert reported.value.problem.status == 409
        # The one that waited when the block was judged has given way.
        job, before = client.jobs(campaign, "identify")
        assert (client.job(job.id).inputs, before.state) == ((run,), "cancelled")
        tripped = client.emergency_stop(RIG, "loose cable")
        assert tripped.trip is not None
        client.reset_rig(RIG, lease, "tightened")
        assert client.rig(RIG).trip is None
    assert client.rig(RIG).lease is None


def test_a_wrong_token_is_reported(lab: Lab) -> None:
    with Client(lab.url, "not the token at all") as stranger, pytest.raises(ServiceProblemError) as reported:
        stranger.rigs()
    assert reported.value.problem.code == "token-needed"
