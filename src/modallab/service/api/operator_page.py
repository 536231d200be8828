"""The operator's page: static files of this package, with nothing from elsewhere."""

from importlib.resources import files
from pathlib import Path
from urllib.parse import urlsplit

from fastapi import FastAPI, Request
from fastapi.staticfiles import StaticFiles
from starlette.responses import Response
from starlette.types import Scope

from modallab.service.api.health import stop_url

FOLDER = Path(str(files("modallab.service") / "page"))


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
    app.mount("/page", _Files(directory=FOLDER, html=True), name="page")
