"""The REST service as an application: access, problems, resources, and its OpenAPI document."""

import gzip
import secrets
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from functools import cache, partial
from importlib import import_module
from threading import Thread
from typing import Any, cast

from fastapi import APIRouter, FastAPI
from fastapi.concurrency import run_in_threadpool
from fastapi.openapi.utils import get_openapi
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.cors import CORSMiddleware
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from modallab import __version__
from modallab.core.discovery import declared_names
from modallab.core.documents.pages import ProblemDetails
from modallab.core.settings import LOOPBACK, Settings
from modallab.service import api
from modallab.service.api.access import COOKIE, AccessGuard
from modallab.service.api.asyncapi import asyncapi_of
from modallab.service.api.blocks import SAMPLE_HEADERS
from modallab.service.api.described import METHODS, describe_operations, describe_schemas, operations_of_document
from modallab.service.api.events import EventFeed
from modallab.service.api.pages import mount_manual, mount_page, mount_static
from modallab.service.api.problems import install_handlers
from modallab.service.api.request_context import LEASE, OPERATOR
from modallab.service.api.router import HEADER as KEY
from modallab.service.api.router import IdempotencyKeys
from modallab.service.context import Service
from modallab.service.records.sessions import BrowserSessions
from modallab.service.records.users import ValidTokens

LEAST = 1000
"""Bytes; less goes into one packet anyway."""
LARGE = 1 << 16
"""Bytes that are compressed beside the event loop: 64 KiB take a millisecond."""
LEVEL = 1
KINDS = ("application/json", "application/problem+json", "text/html", "text/plain", "text/javascript", "text/css")


class GzipResponses:
    """Compresses the answers of an application."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on."""
        if scope["type"] != "http" or not accepts_gzip(Headers(scope=scope).get("accept-encoding", "")):
            await self._app(scope, receive, send)
            return
        head: Message | None = None

        async def compressed(message: Message) -> None:
            nonlocal head
            if message["type"] == "http.response.start" and _is_text(Headers(raw=message["headers"])):
                head = message
                return
            if head is not None:
                begun, head = head, None
                message = await _compress_body(begun, message)
                await send(begun)
            await send(message)

        await self._app(scope, receive, compressed)


def accepts_gzip(accepted: str) -> bool:
    """Whether the header `Accept-Encoding` names gzip, or anything, and does not rule it out (`q=0`)."""
    weights: dict[str, float] = {}
    for part in accepted.lower().split(","):
        name, _, weight = part.partition(";")
        try:
            weights[name.strip()] = float(weight.strip().removeprefix("q=") or 1)
        except ValueError:
            weights[name.strip()] = 0.0
    return weights.get("gzip", weights.get("*", 0.0)) > 0


def _is_text(headers: Headers) -> bool:
    kind = headers.get("content-type", "").partition(";")[0].strip()
    return kind in KINDS and "content-encoding" not in headers


async def _compress_body(head: Message, message: Message) -> Message:
    """The only part of an answer, compressed, with what the head says of it changed; a part of a stream as it is."""
    body: bytes = message.get("body", b"")
    headers = MutableHeaders(raw=head["headers"])
    headers.add_vary_header("Accept-Encoding")
    if message.get("more_body", False) or len(body) < LEAST:
        return message
    compress = partial(gzip.compress, body, LEVEL, mtime=0)
    small = compress() if len(body) < LARGE else await run_in_threadpool(compress)
    headers["Content-Encoding"], headers["Content-Length"] = "gzip", str(len(small))
    tag = headers.get("etag", "")
    if tag.startswith('"'):
        # The same document, but not the same bytes.
        headers["ETag"] = f"W/{tag}"
    return {**message, "body": small}


class HeadRequests:
    """Asks for GET, and sends the head only."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self._app(scope, receive, send)
            return
        sent = False

        async def receive_no_more() -> Message:
            # A stream has no end: it hears that nobody reads it.
            return {"type": "http.disconnect"} if sent else await receive()

        async def head(message: Message) -> None:
            nonlocal sent
            if message["type"] == "http.response.start":
                await send(message)
                await send({"type": "http.response.body", "body": b"", "more_body": False})
                sent = True

        scope["method"] = "GET"
        await self._app(scope, receive_no_more, head)


API_VERSION = "1.2"
"""Grows with every change of the JSON; docs/reference/api.md names the words that changed."""

SUMMARY = "Modal tests on a bench."
ABOUT = """To try a request here, press Authorize and paste the token; the service names its file when
it starts. A command to a rig needs its lease: take the lease at `/api/v1/rigs/{rig}/lease`, and send its `id` as
`Modallab-Lease`. An emergency stop needs no lease."""

ASKED = ("Authorization", "Content-Type", "If-Match", "If-None-Match", "Last-Event-ID", LEASE, OPERATOR, KEY)
"""Headers a page of another site may send, where the setting `cors` names it."""
ANSWERED = ("ETag", "Location", "Retry-After", "Idempotency-Replayed", *SAMPLE_HEADERS, "Modallab-Notes")
"""Headers it may read."""


def create_app(service: Service, settings: Settings, token: str) -> FastAPI:
    """The application for an open service; every request must carry `token`, an admin's, or that of a user."""
    app = FastAPI(
        title="modallab",
        version=__version__,
        openapi_url=None,
        docs_url=None,
        redoc_url=None,
        lifespan=_lifespan,
        generate_unique_id_function=_operation_id,
    )
    app.state.feed = EventFeed(service.log)
    app.state.service, app.state.settings = service, settings
    app.state.keys = IdempotencyKeys(service.engine, secrets.token_hex(8))
    callers = app.state.callers = ValidTokens(service.engine, token)
    app.state.sessions = BrowserSessions(service.engine, callers.cookie_key)
    install_handlers(app)
    routers = resource_routers()
    for router in routers:
        app.include_router(router)
    app.state.routes = [route for router in routers for route in router.routes]
    mount_static(app)
    mount_page(app)
    mount_manual(app, settings.site)
    _add_middleware(app, settings)
    app.openapi = lambda: document_of(app)  # pyrefly: ignore[method-assign]
    app.state.asyncapi = cache(lambda: asyncapi_of(app, API_VERSION))
    app.state.openapi_json = cache(lambda: JSONResponse(app.openapi()).body)
    app.state.asyncapi_json = cache(lambda: JSONResponse(app.state.asyncapi()).body)
    return app


def _add_middleware(app: FastAPI, settings: Settings) -> None:
    app.add_middleware(GzipResponses)
    app.add_middleware(
        AccessGuard,
        callers=app.state.callers,
        sessions=app.state.sessions,
        hosts={*LOOPBACK, settings.host, *settings.hosts},
        body_bytes=settings.body_bytes,
        origins=settings.cors,
        file_bytes=settings.file_bytes,
    )
    app.add_middleware(HeadRequests)
    if settings.cors:
        # Outermost: a browser asks whether it may before it sends a token.
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.cors,
            allow_methods=[method.upper() for method in METHODS],
            allow_headers=ASKED,
            expose_headers=ANSWERED,
        )


def resource_routers() -> list[APIRouter]:
    """The routers of all modules of this package: a new resource needs no entry anywhere."""
    modules = [import_module(f"{api.__name__}.{name}") for name in declared_names(api.__name__)]
    return [value for module in modules for value in vars(module).values() if isinstance(value, APIRouter)]


def _operation_id(route: APIRoute) -> str:
    # Generated clients name their functions so: it is as stable as an address.
    return route.name


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncGenerator[None]:
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
    parts["schemas"]["ProblemDetails"] = ProblemDetails.model_json_schema(ref_template="#/components/schemas/{model}")
    for unused in ("HTTPValidationError", "ValidationError"):
        parts["schemas"].pop(unused, None)
    parts["securitySchemes"] = {
        "token": {"type": "http", "scheme": "bearer"},
        "session": {"type": "apiKey", "in": "cookie", "name": COOKIE},
    }
    document["security"] = [{"token": ["observer"]}, {"session": ["observer"]}]
    describe_schemas(parts["schemas"])
    for operation in operations_of_document(document):
        for parameter in operation.get("parameters", ()):
            _forbid_null(parameter)
    describe_operations(document)
    app.openapi_schema = document
    return document


def _forbid_null(parameter: dict[str, Any]) -> None:
    """A header or a query has no null: it is there or not, which `required` says."""
    schema: dict[str, Any] = parameter["schema"]
    kinds = [kind for kind in cast("list[dict[str, Any]]", schema.get("anyOf", [])) if kind != {"type": "null"}]
    if len(kinds) == 1:
        del schema["anyOf"]
        parameter["schema"] = kinds[0] | schema
