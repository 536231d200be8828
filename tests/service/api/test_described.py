"""The OpenAPI document says of every field, parameter and header what it is, in which unit, and gives an example."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema_rs
import pytest
from lab import RIG, TOKEN, Lab

from modallab.service.api.described import has_value, is_number, operations_of_document

Json = dict[str, Any]
REFERENCE = Path(__file__).parents[3] / "docs" / "reference"
OF_EVERY_ANSWER = {
    "server",
    "content-type",
    "content-length",
    "date",
    "vary",
    "content-encoding",
    "accept-ranges",
    "last-modified",
}


@pytest.fixture(scope="module")
def document(lab: Lab) -> Json:
    return lab.app.openapi()


@pytest.fixture(scope="module", params=["openapi", "asyncapi"])
def either(lab: Lab, request: pytest.FixtureRequest) -> Json:
    return lab.app.openapi() if request.param == "openapi" else lab.app.state.asyncapi()


def fields(document: Json) -> Iterator[tuple[str, Json]]:
    for name, schema in document["components"]["schemas"].items():
        for field, of_field in schema.get("properties", {}).items():
            yield f"{name}.{field}", of_field


def test_every_field_has_a_description_a_unit_and_an_example(either: Json) -> None:
    """To correct: a line in the docstring's Attributes; unit and example in service/api/described.yaml."""
    lacks = [
        f"{name}: description" for name, field in fields(either) if "$ref" not in field and not field.get("description")
    ]
    lacks += [f"{name}: x-unit" for name, field in fields(either) if is_number(field) and "x-unit" not in field]
    lacks += [f"{name}: examples" for name, field in fields(either) if not has_value(field) and "examples" not in field]
    assert lacks == []


def test_every_example_is_one(either: Json) -> None:
    # One schema of all fields: to compile the document for each takes seconds.
    judge = jsonschema_rs.validator_for({"properties": dict(fields(either)), "components": either["components"]})
    given = [(name, example) for name, field in fields(either) for example in field.get("examples", ())]
    assert given
    assert [f"{name}: {example}" for name, example in given if not judge.is_valid({name: example})] == []


def test_every_operation_and_parameter_is_described_under_a_name_of_its_own(document: Json) -> None:
    found = list(operations_of_document(document))
    names = [operation["operationId"] for operation in found]
    assert len(set(names)) == len(names)
    assert all(name.isidentifier() and name.islower() for name in names), "such a name does not hold its address"
    assert [operation["operationId"] for operation in found if not operation.get("description")] == []
    lacks = [
        f"{operation['operationId']} {parameter['name']}"
        for operation in found
        for parameter in operation.get("parameters", ())
        if not parameter.get("description") or "example" not in parameter
    ]
    assert lacks == []


def test_every_header_of_an_answer_is_documented_and_every_documented_one_is_there(lab: Lab, document: Json) -> None:
    known = {operation["operationId"]: operation for operation in operations_of_document(document)}
    campaign = lab.campaign("with headers")
    with lab.client() as client, lab.client(token=None) as stranger:
        asked = {
            "create_campaign": client.post("/api/v1/campaigns", json={"name": "x", "rig": RIG}),
            "get_campaign": client.get(f"/api/v1/campaigns/{campaign}"),
            "change_campaign": client.patch(f"/api/v1/campaigns/{campaign}", json={}, headers={"If-Match": '"1"'}),
            "list_campaigns": client.get("/api/v1/campaigns"),
            "get_rig": stranger.get(f"/api/v1/rigs/{RIG}"),
            "get_job": client.get("/api/v1/jobs/none"),
            "get_health": stranger.get("/health"),
            "log_in": stranger.post("/api/v1/session", json={"token": TOKEN}),
            "get_metrics": client.get("/metrics"),
        }
    for name, answer in asked.items():
        headers: Json = known[name]["responses"][str(answer.status_code)].get("headers", {})
        sent = set(answer.headers) - OF_EVERY_ANSWER
        said = {header.lower() for header in headers}
        needed = {header.lower() for header, about in headers.items() if about["required"]}
        assert needed <= sent <= said, name
        assert all(about["description"] and about["example"] for about in headers.values())


def test_the_messages_are_the_committed_document_and_every_reference_leads_somewhere(lab: Lab) -> None:
    """To take over a change: python docs/reference/make_openapi.py."""
    with lab.client(token=None) as client:
        document = client.get("/asyncapi.json").json()
    assert document == json.loads((REFERENCE / "asyncapi.json").read_text(encoding="utf-8"))
    for reference in re.findall(r'"\$ref": "#/([^"]+)"', json.dumps(document)):
        found = document
        for step in reference.split("/"):
            found = found[step]
    addresses = {channel["address"] for channel in document["channels"].values()}
    assert addresses == {
        "/api/v1/events/stream", "/api/v1/live", "/api/v1/live/envelope", "/api/v1/runs/{run}/frf/live",
    }  # fmt: skip
    for channel in document["channels"].values():
        query = channel["bindings"].get("ws", {}).get("query", channel.get("x-query"))["properties"]
        assert query
        assert all(parameter["description"] for parameter in query.values())
