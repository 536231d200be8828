"""A visit to the bench: plans in turn, events as they come, one campaign at the end."""

from importlib import resources
from pathlib import Path

import pytest

from modallab.campaign.demo_plan import DEMO_POINTS, demo_plans
from modallab.campaign.session import record_campaign
from modallab.errors import PlanError
from modallab.exchange.rig_file import read_rig
from modallab.schema.events import Event
from modallab.schema.plan import ImpactPlan, SinePlan
from modallab.schema.rig import Rig
from modallab.storage import Store


@pytest.fixture(scope="module")
def link_rig() -> Rig:
    return read_rig(Path(str(resources.files("modallab.campaign") / "link_rig.yaml")))


def test_the_demo_does_both_tests_of_the_paper() -> None:
    impact, sine = demo_plans()
    assert isinstance(impact, ImpactPlan)
    assert isinstance(sine, SinePlan)
    assert (impact.points, impact.hits, impact.rate_hz) == (DEMO_POINTS, 5, 2000.0)
    assert (len(sine.frequencies_hz), sine.rate_hz, list(sine.levels_v)) == (24, 1000.0, ["low"])


def test_the_demos_campaign_has_15_good_hits_and_24_sine_blocks(link_rig: Rig, tmp_path: Path) -> None:
    events: list[Event] = []
    campaign = record_campaign("sim://cantilever?seed=1", link_rig, demo_plans(), tmp_path, events.append)
    assert [len(campaign.of("impact")), len(campaign.of("sine"))] == [15, 24]
    assert [b.order for b in campaign.blocks] == list(range(39))
    assert len({b.name for b in campaign.blocks}) == 39
    assert {b.duration_s for b in campaign.blocks} == {1.024}
    assert len([e for e in events if e.kind == "block" and e.accepted]) == 39
    assert campaign.rig == link_rig


def test_a_plan_that_fails_ends_the_visit_and_what_was_recorded_stays(link_rig: Rig, tmp_path: Path) -> None:
    plans = (ImpactPlan(points=(10,), hits=1), SinePlan(levels_v={"low": 99.0}))
    with pytest.raises(PlanError, match="99 V"):
        record_campaign("sim://cantilever?seed=1", link_rig, plans, tmp_path, lambda _: None)
    with Store(tmp_path) as store:
        done, failed = store.catalogue.runs()
        assert (done.state, failed.state) == ("done", "failed")
        assert len(store.blocks(done.id)) == 1
