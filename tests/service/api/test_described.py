"""The OpenAPI document says of every field, parameter and header what it is, in which unit, and gives an example."""

from collections.abc import Iterator
from typing import Any

import jsonschema_rs
import pytest
from lab import RIG, Lab

from modallab.service.api.described import has_value, is_number, operations

Json = dict[str, Any]
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


def fields(document: Json) -> Iterator[tuple[str, Json]]:
    for name, schema in document["components"]["schemas"].items():
        for field, of_field in schema.get("properties", {}).items():
            yield f"{name}.{field}", of_field


def test_every_field_has_a_description_a_unit_and_an_example(document: Json) -> None:
    """To mend: a line in the docstring's Attributes; unit and example in service/api/described.yaml."""
    lacks = [f"{name}: description" for name, field in fields(document) if not field.get("description")]
    lacks += [f"{name}: x-unit" for name, field in fields(document) if is_number(field) and "x-unit" not in field]
    lacks += [
        f"{name}: examples" for name, field in fields(document) if not has_value(field) and "examples" not in field
    ]
    assert lacks == []


def test_every_example_is_one(document: Json) -> None:
    wrong: list[str] = []
    for name, field in fields(document):
        judge = jsonschema_rs.validator_for({**field, "components": document["components"]})
        wrong += [f"{name}: {example}" for example in field.get("examples", ()) if not judge.is_valid(example)]
    assert wrong == []


def test_every_operation_and_parameter_is_described_under_a_name_of_its_own(document: Json) -> None:
    found = list(operations(document))
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
    known = {operation["operationId"]: operation for operation in operations(document)}
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
            "log_in": stranger.post("/api/v1/session", json={"token": lab.app.state.token}),
            "get_metrics": client.get("/metrics"),
        }
    for name, answer in asked.items():
        headers: Json = known[name]["responses"][str(answer.status_code)].get("headers", {})
        sent = set(answer.headers) - OF_EVERY_ANSWER
        said = {header.lower() for header in headers}
        needed = {header.lower() for header, about in headers.items() if about["required"]}
        assert needed <= sent <= said, name
        assert all(about["description"] and about["example"] for about in headers.values())
