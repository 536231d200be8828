"""What came after what is a matter of numbers: a clock that is set back changes no list."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from postgresql_server import DATABASES

from modallab.core.documents.runs import CampaignRequest
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.service.records import repository
from modallab.service.records.repository import CampaignRepository, RunEntry
from modallab.storage import Store
from modallab.storage.engine import name_database
from modallab.storage.records import RunRecord


@pytest.fixture(params=DATABASES)
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Store]:
    if request.param == "postgresql":
        name_database(tmp_path / "data", request.getfixturevalue("postgresql").new_database())
    with Store(tmp_path / "data") as opened:
        yield opened


class Slow(datetime):
    """A clock that goes backwards, an hour with every look."""

    looks = 0

    @classmethod
    def now(cls, tz=None) -> datetime:  # type: ignore[override]
        cls.looks += 1
        return datetime.now(tz) - timedelta(hours=cls.looks)


def test_campaigns_and_runs_are_listed_as_they_were_made(
    store: Store, link_rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(repository, "datetime", Slow)
    campaigns = CampaignRepository(store.catalogue.engine)
    made = [campaigns.create(CampaignRequest(name=f"n{n}", rig="link"), "Ada").id for n in range(4)]
    assert made == sorted(made, reverse=True)
    assert [found.id for found in campaigns.campaigns(None, 10)] == made[::-1]
    assert [found.id for found in campaigns.campaigns(made[2], 10)] == [made[1], made[0]]
    record = RunRecord(
        id="", test="impact", state="done", reason="", valid=True, plan=ImpactPlan(points=(1,)), rig=link_rig,
        rig_hash="", bench_url="", facts={}, code_version="", created_utc="", ended_utc="", rates=None, dtype="",
        scale=(), units=(),
    )  # fmt: skip
    for name in ("run-b", "run-a"):
        store.catalogue.add_run(replace(record, id=name))
        campaigns.add_run(RunEntry(name, made[0], "link", "Ada", None), {})
    assert [run.id for run in store.catalogue.runs()] == ["run-b", "run-a"]
    assert campaigns.campaign(made[0]).runs == ("run-b", "run-a")
