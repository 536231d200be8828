"""The OpenAPI document is the one that is committed, and says of every route how it may fail."""

import json
from pathlib import Path

from fastapi.responses import JSONResponse
from lab import Lab

from modallab.core.errors import DeviceBusyError, DeviceGoneError
from modallab.service.api.problems import kind_of, problem_kinds

ROOT = Path(__file__).parents[3]
COMMITTED = ROOT / "docs" / "reference" / "openapi.json"


def test_the_document_is_the_committed_one(lab: Lab) -> None:
    """To take over a change: python docs/reference/make_openapi.py."""
    assert json.loads(json.dumps(lab.app.openapi())) == json.loads(COMMITTED.read_text(encoding="utf-8"))


def test_the_document_is_serialised_once_and_every_answer_is_its_text(lab: Lab) -> None:
    with lab.client(None) as client:
        for address, document in (("/openapi.json", lab.app.openapi()), ("/asyncapi.json", lab.app.state.asyncapi())):
            first, second = client.get(address), client.get(address)
            assert first.content == second.content == JSONResponse(document).body
            assert first.headers["content-type"] == "application/json"
    assert lab.app.state.openapi_json() is lab.app.state.openapi_json()


def test_codes_and_statuses_are_those_that_clients_know() -> None:
    assert {kind.code: kind.status for kind in problem_kinds().values()} == {
        "bench": 503, "bench-busy": 409, "block-damaged": 500, "changed": 412, "media-type": 415, "row-damaged": 500,
        "conflict": 409, "database-lost": 503, "data": 422, "disk_full": 507, "error": 500,
        "foreign-host": 403, "foreign-origin": 403, "format": 422, "idempotency-key": 422, "identification": 422,
        "illegal-transition": 409, "job": 422, "job-unknown": 404, "lease-held": 409, "lease-needed": 403,
        "no-page": 404, "package": 501, "not-allowed": 405, "not-found": 404, "not-valid": 422, "plan": 422,
        "precondition-needed": 428,
        "rig": 422, "rig-unavailable": 503, "role-needed": 403, "safety": 409, "service": 409, "storage": 500,
        "token-needed": 401, "too-large": 413, "tripped": 409, "unexpected": 500,
    }  # fmt: skip


def test_an_error_without_an_answer_of_its_own_is_answered_as_the_class_above_it() -> None:
    assert kind_of(DeviceGoneError("unplugged")).code == "bench"
    assert kind_of(DeviceBusyError("held")).status == 409


def test_every_object_of_ours_rejects_unknown_fields(lab: Lab) -> None:
    schemas = lab.app.openapi()["components"]["schemas"]
    asked = [
        "CampaignRequest",
        "CampaignChange",
        "RunRequest",
        "LeaseRequest",
        "JobRequest",
        "BlockVerdict",
        "LoginRequest",
        "PauseRun",
        "DropHit",
    ]
    assert all(schemas[name]["additionalProperties"] is False for name in asked)
