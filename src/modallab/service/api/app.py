"""The REST service as an application: access, problems, resources, and its OpenAPI document."""

import secrets
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from importlib import import_module
from threading import Thread
from typing import Any, cast

from fastapi import APIRouter, FastAPI
from fastapi.openapi.utils import get_openapi

from modallab import __version__
from modallab.core.discovery import declared_names
from modallab.core.documents.pages import Problem
from modallab.core.settings import LOOPBACK, Settings
from modallab.service import api
from modallab.service.api.access import COOKIE, Guard
from modallab.service.api.events import Feed
from modallab.service.api.head import HeadAsGet
from modallab.service.api.operator_page import mount_page
from modallab.service.api.pages import mount_static
from modallab.service.api.problems import install
from modallab.service.api.router import Keys
from modallab.service.context import Service
from modallab.service.records.callers import Callers
from modallab.service.records.sessions import Sessions

API_VERSION = "1.1"
"""Grows with every change of the JSON; docs/reference/api.md names the words that changed."""

SUMMARY = "Modal tests on a bench."
ABOUT = """To try a request here, press Authorize and paste the token; it stands in the file that the service named when
it began. What commands a rig needs its lease: take it at `/api/v1/rigs/{rig}/lease`, and send its `id` as
`Modallab-Lease`. An emergency stop needs no lease."""

METHODS = ("get", "put", "post", "patch", "delete")


def create_app(service: Service, settings: Settings, token: str) -> FastAPI:
    """The application for an open service; every request must carry `token`, an admin's, or that of a user."""
    app = FastAPI(title="modallab", version=__version__, docs_url=None, redoc_url=None, lifespan=_life)
    app.state.feed = Feed(service.log)
    app.state.service, app.state.settings = service, settings
    app.state.keys = Keys(service.engine, secrets.token_hex(8))
    callers = app.state.callers = Callers(service.engine, token)
    app.state.sessions = Sessions(service.engine, callers.secret)
    install(app)
    routers = resources()
    for router in routers:
        app.include_router(router)
    app.state.routes = [route for router in routers for route in router.routes]
    mount_static(app)
    mount_page(app)
    hosts = {*LOOPBACK, settings.host, *settings.hosts}
    app.add_middleware(Guard, callers=callers, sessions=app.state.sessions, hosts=hosts, body_bytes=settings.body_bytes)
    app.add_middleware(HeadAsGet)
    app.openapi = lambda: document_of(app)
    return app


def resources() -> list[APIRouter]:
    """The routers of all modules of this package: a new resource needs no entry anywhere."""
    modules = [import_module(f"{api.__name__}.{name}") for name in declared_names(api.__name__)]
    return [value for module in modules for value in vars(module).values() if isinstance(value, APIRouter)]


@asynccontextmanager
async def _life(app: FastAPI) -> AsyncGenerator[None]:
    app.state.feed.open()
    app.state.callers.open()
    Thread(target=import_module, args=("modallab.service.campaigns.live_frf",), name="warm up", daemon=True).start()
    yield
    app.state.callers.close()
    app.state.feed.close()


def document_of(app: FastAPI) -> dict[str, Any]:
    """The document of an application, made once."""
    if app.openapi_schema:
        return app.openapi_schema
    document = get_openapi(title=app.title, version=API_VERSION, routes=app.routes, summary=SUMMARY, description=ABOUT)
    parts: dict[str, Any] = document["components"]
    parts["schemas"]["Problem"] = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
    for unused in ("HTTPValidationError", "ValidationError"):
        parts["schemas"].pop(unused, None)
    parts["securitySchemes"] = {
        "token": {"type": "http", "scheme": "bearer"},
        "session": {"type": "apiKey", "in": "cookie", "name": COOKIE},
    }
    document["security"] = [{"token": ["observer"]}, {"session": ["observer"]}]
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
