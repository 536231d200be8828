"""Models, comparisons and diagnoses as resources: the same as the jobs gave, and whether they are still current."""

from collections.abc import Iterator

import numpy as np
import pytest
from furnished import furnish
from lab import RIG, Lab

from modallab.core.documents.models import ComparisonView, ModelsView
from modallab.core.rig import Rig

API = "/api/v1"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory, link_rig: Rig) -> Iterator[Lab]:
    made = furnish(tmp_path_factory.mktemp("results") / "data", link_rig)
    yield made
    made.close()


@pytest.fixture(scope="module")
def campaign(lab: Lab) -> str:
    return next(c.id for c in lab.service.repository.campaigns(None, 10) if c.runs)


@pytest.fixture(scope="module")
def run(lab: Lab, campaign: str) -> str:
    return lab.service.repository.campaign(campaign).runs[0]


def test_a_model_is_that_of_its_job_and_lists_are_without_it(lab: Lab, campaign: str, run: str) -> None:
    with lab.client() as client:
        answer = client.get(f"{API}/campaigns/{campaign}/model").json()
        assert client.get(f"{API}/runs/{run}/model").json() == answer
        found = ModelsView.model_validate(answer)
        job = client.get(f"{API}/jobs/{found.job}").json()
        listed = client.get(f"{API}/campaigns/{campaign}/jobs").json()["items"]
        of_run = client.get(f"{API}/runs/{run}/jobs").json()["items"]
    (document,) = job["result"]["document"]["models"]
    (model,) = found.models
    np.testing.assert_array_equal(model.model.frequency_hz, document["frequency_hz"])
    np.testing.assert_array_equal(model.frac, document["frac"])
    assert model.assessment is not None
    assert len(model.assessment.confidence) == model.model.n_modes
    assert found.runs == (run,)
    assert {one["id"] for one in listed} == {one["id"] for one in of_run}
    assert all(one["result"] is None for one in listed + of_run)


def test_a_run_compared_with_itself_does_not_differ(lab: Lab, run: str) -> None:
    with lab.client() as client:
        answer = client.get(f"{API}/comparison", params={"one": run, "other": run})
        missing = client.get(f"{API}/comparison", params={"one": run, "other": "no-such-run"})
    same = ComparisonView.model_validate(answer.json())
    assert same.modes == tuple((n, n) for n in range(len(same.modes)))
    np.testing.assert_array_equal(same.difference_percent, 0)
    np.testing.assert_allclose(same.mac, 1, atol=1e-12)
    assert same.alone == ((), ())
    assert missing.status_code == 404


def test_what_is_not_there_yet_says_how_to_get_it(lab: Lab, campaign: str) -> None:
    with lab.client() as client:
        gap = client.get(f"{API}/campaigns/{campaign}/gap")
        empty = next(c.id for c in lab.service.repository.campaigns(None, 10) if not c.runs)
        model = client.get(f"{API}/campaigns/{empty}/model")
    assert gap.status_code == model.status_code == 404
    assert "order one" in gap.json()["remedy"]


def test_a_model_is_not_current_once_another_block_counts(lab: Lab, run: str) -> None:
    lease = lab.service.leases.take(RIG, "Ada", 60.0)
    with lab.client() as client:
        place, headers = f"{API}/runs/{run}", {"Modallab-Lease": lease.id}
        assert client.get(f"{place}/model").json()["current"]
        for accepted in (False, True):
            verdict = {"accepted": accepted, "reason": "a slip"}
            client.put(f"{place}/blocks/0/verdict", json=verdict, headers=headers).raise_for_status()
            assert client.get(f"{place}/model").json()["current"] is accepted
    lab.service.leases.release(RIG, lease.id)
