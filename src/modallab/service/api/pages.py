"""Pages for people, with nothing from elsewhere: the operator's, the API's documentation, a page for every problem."""

import re
from html import escape
from importlib.resources import files
from pathlib import Path
from urllib.parse import urlsplit

import fastapi_offline
from fastapi import APIRouter, FastAPI, Request
from fastapi.openapi.docs import get_swagger_ui_html
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from fastapi.staticfiles import StaticFiles
from starlette.types import Scope

from modallab.service.api.health import stop_url
from modallab.service.api.problems import problem_kinds
from modallab.service.errors import NotFoundError

router = APIRouter(include_in_schema=False)
_STYLE = "body{font:18px/1.5 system-ui,sans-serif;max-width:42em;margin:3em auto;padding:0 1em}code{font-size:.95em}"
_FOLDER = Path(str(files("modallab.service") / "page"))


@router.get("/")
def redirect_to_page() -> RedirectResponse:
    """Who types the address alone is led to the operator's page."""
    return RedirectResponse("/page/")


@router.get("/docs")
def show_api() -> HTMLResponse:
    """The API, to read and to try."""
    return get_swagger_ui_html(
        openapi_url="/openapi.json",
        title="modallab",
        swagger_js_url="/docs/static/swagger-ui-bundle.js",
        swagger_css_url="/docs/static/swagger-ui.css",
        swagger_favicon_url="/docs/static/favicon.png",
    )


@router.get("/openapi.json")
def show_document(request: Request) -> Response:
    """The OpenAPI document; serialised once, since that takes a tenth of a second."""
    return Response(request.app.state.openapi_json(), media_type="application/json")


@router.get("/asyncapi.json")
def show_messages(request: Request) -> Response:
    """What the service sends by itself, as an AsyncAPI document."""
    return Response(request.app.state.asyncapi_json(), media_type="application/json")


@router.get("/problems/{code}")
def show_problem(code: str) -> HTMLResponse:
    """What a kind of problem means."""
    kind = problem_kinds().get(code)
    if kind is None:
        raise NotFoundError(f"there is no kind of problem {code!r}", remedy=f"known: {', '.join(problem_kinds())}")
    return HTMLResponse(
        f"<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'>"
        f"<title>{escape(kind.title)}</title><style>{_STYLE}</style>"
        f"<h1>{escape(kind.title)}</h1><p><code>{escape(code)}</code>, status {kind.status}</p>"
        f"<p>{_code_marked(kind.meaning)}</p><p><a href=/docs>The API</a></p></html>"
    )


def _code_marked(text: str) -> str:
    """What stands between backticks is code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text))


def mount_static(app: FastAPI) -> None:
    """Serve Swagger UI from the package it comes in."""
    folder = Path(str(files(fastapi_offline) / "static"))
    app.mount("/docs/static", StaticFiles(directory=folder), name="swagger-ui")


def mount_manual(app: FastAPI, folder: Path | None) -> None:
    """Serve the built manual at `/manual/`, where there is one."""
    if folder is not None:
        app.mount("/manual", StaticFiles(directory=folder, html=True), name="manual")


class _Files(StaticFiles):
    """Files of the page: asked for again each time, so that versions never mix; and nothing else may be loaded."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        response = await super().get_response(path, scope)
        stop = urlsplit(stop_url(Request(scope)))
        response.headers["Cache-Control"] = "no-cache"
        response.headers["Content-Security-Policy"] = (
            f"default-src 'self'; img-src 'self' data:; connect-src 'self' {stop.scheme}://{stop.netloc};"
            " frame-ancestors 'none'; base-uri 'none'; form-action 'self'; object-src 'none'"
        )
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "no-referrer"
        return response


def mount_page(app: FastAPI) -> None:
    """Serve the page at `/page/`."""
    app.mount("/page", _Files(directory=_FOLDER, html=True), name="page")
