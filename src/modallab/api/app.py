"""The REST service as an application: guard, problems, resources."""

from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from importlib import import_module
from threading import Thread
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from modallab import __version__
from modallab.api import (
    blocks,
    campaigns,
    devices,
    events,
    frfs,
    health,
    jobs,
    leases,
    live,
    pages,
    reports,
    rigs,
    runs,
    session,
)
from modallab.api.feed import Feed
from modallab.api.guard import COOKIE, Guard
from modallab.api.live import LiveHub
from modallab.api.problems import install
from modallab.campaign.service import Service
from modallab.schema.service.pages import Problem
from modallab.settings import LOOPBACK, Settings

RESOURCES = (session, rigs, leases, devices, campaigns, runs, blocks, frfs, jobs, reports, events, live, health, pages)


def create_app(service: Service, settings: Settings, token: str) -> FastAPI:
    """The application for an open service; every request must carry `token`."""
    app = FastAPI(title="modallab", version=__version__, docs_url=None, redoc_url=None, lifespan=_life)
    app.state.live = LiveHub()
    app.state.service, app.state.settings, app.state.token = service, settings, token
    install(app)
    for resource in RESOURCES:
        app.include_router(resource.router)
    pages.mount_static(app)
    hosts = {*LOOPBACK, settings.host, *settings.hosts}
    app.add_middleware(Guard, token=token, hosts=hosts, body_bytes=settings.body_bytes)
    app.openapi = lambda: _document(app)
    return app


@asynccontextmanager
async def _life(app: FastAPI) -> AsyncGenerator[None]:
    app.state.feed = Feed(app.state.service.log)
    app.state.feed.open()
    app.state.live.open()
    Thread(target=import_module, args=("modallab.campaign.live_frf",), name="warm up", daemon=True).start()
    yield
    app.state.feed.close()


def _document(app: FastAPI) -> dict[str, Any]:
    if app.openapi_schema:
        return app.openapi_schema
    document = get_openapi(title=app.title, version="1", routes=app.routes, summary="Modal tests on a bench.")
    parts: dict[str, Any] = document["components"]
    parts["schemas"]["Problem"] = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
    for unused in ("HTTPValidationError", "ValidationError"):
        parts["schemas"].pop(unused, None)
    parts["securitySchemes"] = {
        "token": {"type": "http", "scheme": "bearer"},
        "session": {"type": "apiKey", "in": "cookie", "name": COOKIE},
    }
    document["security"] = [{"token": []}, {"session": []}]
    app.openapi_schema = document
    return document
