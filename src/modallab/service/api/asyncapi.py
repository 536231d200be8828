"""The AsyncAPI document: events by SSE and live arrays by WebSocket, made of the types that are sent."""

from collections.abc import Iterable
from typing import Any, get_args

from fastapi import FastAPI
from fastapi.routing import APIWebSocketRoute
from pydantic import BaseModel, TypeAdapter
from pydantic.json_schema import models_json_schema
from starlette.routing import compile_path

from modallab.core.documents.messages import AnyEvent, EnvelopeHeader, LiveFrfHeader, SamplesHeader
from modallab.core.documents.pages import EventView
from modallab.service.api.described import describe_schemas, described_words, operations_of_document

Json = dict[str, Any]
REF = "#/components/schemas/{model}"
FRAME = (
    "4 bytes with the length of a JSON text (little-endian), the text, and an array (C order, little-endian) whose"
    " `dtype` and `shape` stand in the text. The text is described as the message's headers, the array is its payload."
)
ARRAYS: dict[str, type[BaseModel]] = {
    "show_samples": SamplesHeader,
    "show_envelope": EnvelopeHeader,
    "show_frf": LiveFrfHeader,
}
"""What stands before the array, by the function that sends it."""
EVENTS = "follow_events"


def asyncapi_of(app: FastAPI, version: str) -> Json:
    """The document of an application."""
    kinds = event_kinds()
    _, found = models_json_schema([(model, "serialization") for model in (*kinds, *ARRAYS.values())], ref_template=REF)
    schemas: Json = found["$defs"] | {_view_name(kind): _content_view(kind) for kind in kinds}
    describe_schemas(schemas)
    channels: Json = {EVENTS: _events_channel(app, kinds)}
    messages: Json = {_kind_of(kind): _event_message(kind) for kind in kinds}
    for route in _websocket_routes(app):
        about = ARRAYS[route.name]
        channels[route.name] = _socket_channel(route, about)
        messages[about.__name__] = _array_message(about)
    return {
        "asyncapi": "3.0.0",
        "info": {
            "title": "modallab",
            "version": version,
            "description": "Messages that the service sends. Requests and answers are in openapi.json.",
        },
        "defaultContentType": "application/json",
        "channels": channels,
        "operations": {name: _operation(name, channel) for name, channel in channels.items()},
        "components": {"schemas": schemas, "messages": messages},
    }


def event_kinds() -> tuple[type[BaseModel], ...]:
    """The types of an event's content."""
    members: list[type[BaseModel]] = []
    for member in get_args(get_args(AnyEvent)[0]):
        # The events of a run are a union of their own.
        inner = get_args(member)
        members += get_args(inner[0]) if inner else [member]
    return tuple(members)


def _kind_of(model: type[BaseModel]) -> str:
    return str(model.model_fields["kind"].default)


def _view_name(model: type[BaseModel]) -> str:
    return f"EventView_{model.__name__}"


def _content_view(model: type[BaseModel]) -> Json:
    """A line of the log whose content is of one kind."""
    schema = EventView.model_json_schema(ref_template=REF)
    schema["properties"]["kind"] |= {"const": _kind_of(model)}
    schema["properties"]["content"] = {"$ref": REF.format(model=model.__name__)}
    return schema


def _event_message(model: type[BaseModel]) -> Json:
    about = model.__doc__ or ""
    return {
        "name": _kind_of(model),
        "summary": about.partition("\n")[0],
        "description": f"`event: {_kind_of(model)}`, its number as `id`, and this as `data`.",
        "payload": {"$ref": REF.format(model=_view_name(model))},
    }


def _array_message(about: type[BaseModel]) -> Json:
    return {
        "name": about.__name__,
        "summary": (about.__doc__ or "").partition("\n")[0],
        "description": FRAME,
        "contentType": "application/octet-stream",
        "headers": {"$ref": REF.format(model=about.__name__)},
        "payload": {"type": "string", "format": "binary"},
    }


def _events_channel(app: FastAPI, kinds: Iterable[type[BaseModel]]) -> Json:
    document = app.openapi()
    asked = next(one for one in operations_of_document(document) if one["operationId"] == EVENTS)
    query = {
        one["name"]: one["schema"] | {"description": one["description"]}
        for one in asked["parameters"]
        if one["in"] == "query"
    }
    return {
        "address": next(path for path, methods in document["paths"].items() if asked in methods.values()),
        "title": asked["summary"],
        "description": f"{asked['description']} By HTTP, as `text/event-stream`.",
        "messages": _references(_kind_of(kind) for kind in kinds),
        "bindings": {"http": {}},
        "x-query": {"type": "object", "properties": query},
    }


def _socket_channel(route: APIWebSocketRoute, about: type[BaseModel]) -> Json:
    query = {field.alias: _query_schema(field.field_info) for field in route.dependant.query_params}
    names = compile_path(route.path)[2]
    return {
        "address": route.path,
        "title": (route.endpoint.__doc__ or "").partition("\n")[0],
        "messages": _references([about.__name__]),
        "parameters": {name: {"description": described_words()["parameters"][name]["description"]} for name in names},
        "bindings": {"ws": {"method": "GET", "query": {"type": "object", "properties": query}}},
    }


def _query_schema(info: Any) -> Json:
    schema = TypeAdapter(info.annotation).json_schema()
    return schema | {"description": info.description or ""}


def _references(names: Iterable[str]) -> Json:
    return {name: {"$ref": f"#/components/messages/{name}"} for name in names}


def _operation(name: str, channel: Json) -> Json:
    return {
        "action": "send",
        "channel": {"$ref": f"#/channels/{name}"},
        "summary": channel["title"],
        "messages": [{"$ref": f"#/channels/{name}/messages/{message}"} for message in channel["messages"]],
    }


def _websocket_routes(app: FastAPI) -> list[APIWebSocketRoute]:
    return [route for route in app.state.routes if isinstance(route, APIWebSocketRoute)]
