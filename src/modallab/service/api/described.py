"""What a document of the API says besides the docstrings: units and examples of fields, parameters, headers."""

from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import Any, cast

import yaml

METHODS = ("get", "put", "post", "patch", "delete")
Json = dict[str, Any]


@cache
def described_words() -> Json:
    """The file beside this one."""
    return cast("Json", yaml.safe_load((files(__package__ or "") / "described.yaml").read_text(encoding="utf-8")))


def describe_schemas(schemas: Mapping[str, Json]) -> None:
    """Add the unit of every number (`x-unit`), and an example of what has neither a default nor a list of values."""
    for name, schema in schemas.items():
        for field, of_field in schema.get("properties", {}).items():
            _describe_field(name.partition("_")[0] if name.startswith("Page_") else name, field, of_field)


def describe_operations(document: Json) -> None:
    """Describe parameters that do not do it themselves, and the headers of answers."""
    for operation in operations_of_document(document):
        for parameter in operation.get("parameters", ()):
            known = described_words()["parameters"].get(parameter["name"], {})
            for key, value in known.items():
                parameter.setdefault(key, value)
        for status, answer in operation["responses"].items():
            headers = dict(_response_headers(operation, status))
            if headers:
                answer.setdefault("headers", {}).update(headers)


def operations_of_document(document: Json) -> Iterator[Json]:
    """Every operation of a document."""
    for path in document["paths"].values():
        for method in METHODS:
            if method in path:
                yield path[method]


def _describe_field(document: str, field: str, schema: Json) -> None:
    unit = _unit_of_field(document, field) if is_number(schema) else None
    if unit is not None:
        schema["x-unit"] = unit
    if has_value(schema) or "examples" in schema:
        return
    examples = described_words()["examples"]
    for key in (f"{document}.{field}", field):
        if key in examples:
            schema["examples"] = [examples[key]]
            return


def _unit_of_field(document: str, field: str) -> str | None:
    units, suffixes = described_words()["units"], described_words()["suffixes"]
    known = units.get(f"{document}.{field}", units.get(field))
    ends = [suffix for suffix in suffixes if field.endswith(suffix)]
    return known or (suffixes[max(ends, key=len)] if ends else None)


def is_number(schema: Json) -> bool:
    """Whether a field holds numbers that may have a unit: real ones, or arrays of them. Whole numbers count."""
    if schema.get("type") in ("number", "array") and "prefixItems" not in schema:
        return schema["type"] == "number" or schema.get("items") == {} or is_number(schema.get("items", {}))
    if schema.get("type") == "object" and "re" in schema.get("properties", {}):
        return True
    parts = [*schema.get("anyOf", ()), *schema.get("prefixItems", ())]
    more = schema.get("additionalProperties")
    return any(is_number(part) for part in [*parts, *([more] if isinstance(more, dict) else [])])


def has_value(schema: Json) -> bool:
    """Whether a schema names a value itself: a default, a list of values, or another document."""
    if any(key in schema for key in ("enum", "const", "$ref", "oneOf")) or schema.get("default") not in (
        None,
        "",
        [],
        {},
    ):
        return True
    parts = [*schema.get("anyOf", ()), schema.get("items"), schema.get("additionalProperties")]
    return any(has_value(part) for part in parts if isinstance(part, dict))


def _response_headers(operation: Json, status: str) -> Iterator[tuple[str, Json]]:
    asked = {parameter["name"] for parameter in operation.get("parameters", ())}
    for part, required in (("headers", True), ("optional", False)):
        for name, header in described_words()[part].items():
            statuses = header["of"].get(operation["operationId"], []) + header["of"].get("any", [])
            # Whoever takes the header `with` may answer with this one.
            if int(status) in statuses or (header.get("with") in asked and status.startswith("2")):
                schema = {"type": "string"}
                about = {"description": header["description"], "example": header["example"]}
                yield name, {**about, "required": required, "schema": schema}
