"""The OpenAPI document is the one that is committed, and says of every route how it may fail."""

import json
from pathlib import Path

from lab import Lab

from modallab.service.api.problem_kinds import KINDS, OF_ERROR

ROOT = Path(__file__).parents[3]
COMMITTED = ROOT / "docs" / "reference" / "openapi.json"


def test_the_document_is_the_committed_one(lab: Lab) -> None:
    """To take over a change: python docs/reference/make_openapi.py."""
    assert json.loads(json.dumps(lab.app.openapi())) == json.loads(COMMITTED.read_text(encoding="utf-8"))


def test_every_kind_of_problem_is_on_its_page() -> None:
    text = (ROOT / "docs" / "reference" / "problems.md").read_text(encoding="utf-8")
    for kind in KINDS.values():
        assert f"| `{kind.code}` | {kind.status} | {kind.title} | {kind.meaning} |" in text


def test_a_kinds_code_is_that_of_its_error() -> None:
    for error, kind in OF_ERROR.items():
        assert kind.code == error.code


def test_every_object_of_ours_rejects_unknown_fields(lab: Lab) -> None:
    schemas = lab.app.openapi()["components"]["schemas"]
    asked = ["CampaignNew", "CampaignChange", "RunNew", "LeaseNew", "JobNew", "Verdict", "Login", "Pause", "Drop"]
    assert all(schemas[name]["additionalProperties"] is False for name in asked)
