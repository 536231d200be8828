"""The OpenAPI document: what FastAPI writes, put right where it says what HTTP cannot."""

from typing import Any, cast

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from modallab.core.documents.pages import Problem
from modallab.service.api.guard import COOKIE

OPEN: dict[str, Any] = {"security": []}
"""For routes that need no token."""

SUMMARY = "Modal tests on a bench."
ABOUT = """To try a request here, press Authorize and paste the token; it stands in the file that the service named when
it began. What commands a rig needs its lease: take it at `/api/v1/rigs/{rig}/lease`, and send its `id` as
`Modallab-Lease`. An emergency stop needs no lease."""

METHODS = ("get", "put", "post", "patch", "delete")


def document_of(app: FastAPI) -> dict[str, Any]:
    """The document of an application, made once."""
    if app.openapi_schema:
        return app.openapi_schema
    document = get_openapi(title=app.title, version="1", routes=app.routes, summary=SUMMARY, description=ABOUT)
    parts: dict[str, Any] = document["components"]
    parts["schemas"]["Problem"] = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
    for unused in ("HTTPValidationError", "ValidationError"):
        parts["schemas"].pop(unused, None)
    parts["securitySchemes"] = {
        "token": {"type": "http", "scheme": "bearer"},
        "session": {"type": "apiKey", "in": "cookie", "name": COOKIE},
    }
    document["security"] = [{"token": []}, {"session": []}]
    for path in document["paths"].values():
        for method in path.keys() & METHODS:
            for parameter in path[method].get("parameters", ()):
                _no_null(parameter)
    app.openapi_schema = document
    return document


def _no_null(parameter: dict[str, Any]) -> None:
    """A header or a query has no null: it is there or not, which `required` says."""
    schema: dict[str, Any] = parameter["schema"]
    kinds = [kind for kind in cast("list[dict[str, Any]]", schema.get("anyOf", [])) if kind != {"type": "null"}]
    if len(kinds) == 1:
        del schema["anyOf"]
        parameter["schema"] = kinds[0] | schema
