"""Revisions of a rig over HTTP, and which description counts after a start."""

from collections.abc import Iterator

import pytest
from lab import RIG, Lab
from lab_fixtures import URL

from modallab.core.rig import DampingPrior, Rig
from modallab.service.records.rig_revisions import RigRevisions

API = f"/api/v1/rigs/{RIG}"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory, link_rig: Rig) -> Iterator[Lab]:
    """Of its own: nobody else's rig is to be revised."""
    with Lab(tmp_path_factory.mktemp("revised") / "data", link_rig, URL) as made:
        made.wait_until_idle()
        yield made


def revised(rig: Rig, damping_ratio: float) -> Rig:
    return rig.model_copy(update={"damping_ratio": DampingPrior(guess=damping_ratio)})


def test_a_rig_is_revised_and_opened_anew(lab: Lab, link_rig: Rig) -> None:
    lease = {"Modallab-Lease": lab.lease().id}
    other = revised(link_rig, 0.0123)
    # As a rig file has it: the service of these tests takes small bodies only.
    body = {"description": other.model_dump(mode="json", exclude_defaults=True), "reason": "a longer ring-down"}
    with lab.client() as client:
        assert client.post(f"{API}/revisions", json=body).json()["code"] == "lease-needed"
        answer = client.post(f"{API}/revisions", json=body, headers=lease)
        assert answer.status_code == 201, answer.text
        lab.wait_until_idle()
        assert Rig.model_validate(client.get(f"{API}/description").json()) == other
        found = client.get(f"{API}/revisions").json()["items"]
        assert [(one["reason"], one["operator"]) for one in found] == [("a longer ring-down", "Ada")]
        assert found[0]["rig_hash"] == client.get(API).json()["rig_hash"]
        assert Rig.model_validate(client.get(f"{API}/revisions/1").json()) == other
        assert client.get(f"{API}/revisions/2").status_code == 404
        body["description"]["name"] = "another"
        assert client.post(f"{API}/revisions", json=body, headers=lease).json()["code"] == "conflict"


def test_a_changed_rig_file_counts_and_an_unchanged_one_does_not_undo(lab: Lab, link_rig: Rig) -> None:
    revisions = RigRevisions(lab.store.catalogue.engine)
    assert revisions.begin_with("bench", link_rig) == link_rig
    later = revised(link_rig, 0.02)
    revisions.add("bench", later, "diagnosed", "Ada")
    assert revisions.begin_with("bench", link_rig) == later
    changed = revised(link_rig, 0.03)
    assert revisions.begin_with("bench", changed) == changed
    assert [one.number for one in revisions.all_revisions("bench")] == [1, 2, 3]
