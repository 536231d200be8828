"""The REST service as an application: guard, problems, resources."""

from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from importlib import import_module
from threading import Thread

from fastapi import FastAPI

from modallab import __version__
from modallab.core.settings import LOOPBACK, Settings
from modallab.service.api import (
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
from modallab.service.api.event_feed import Feed
from modallab.service.api.guard import Guard
from modallab.service.api.live import LiveHub
from modallab.service.api.openapi_document import document_of
from modallab.service.api.problems import install
from modallab.service.context import Service

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
    app.openapi = lambda: document_of(app)
    return app


@asynccontextmanager
async def _life(app: FastAPI) -> AsyncGenerator[None]:
    app.state.feed = Feed(app.state.service.log)
    app.state.feed.open()
    app.state.live.open()
    Thread(target=import_module, args=("modallab.service.campaigns.live_frf",), name="warm up", daemon=True).start()
    yield
    app.state.feed.close()
