"""Errors as problem details (RFC 9457): what was wrong, what to do, and a page that explains the kind."""

import logging
import secrets
from collections.abc import Mapping
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.routing import Match, Route

from modallab.acquisition.monitor.run_states import IllegalTransitionError
from modallab.acquisition.process.trip import TrippedError
from modallab.core.documents.pages import Problem
from modallab.core.errors import ModallabError
from modallab.service.api.problem_kinds import KINDS, Kind, kind_of

LOG = logging.getLogger(__name__)
MEDIA_TYPE = "application/problem+json"
RESET = "look at the bench, then POST to the rig's `reset`, with its lease"

Responses = dict[int | str, dict[str, Any]]


def documented(*statuses: int) -> Responses:
    """What a route may answer with besides its result, for the OpenAPI document."""
    content: dict[str, Any] = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}}
    titles: dict[int, list[str]] = {}
    for kind in KINDS.values():
        titles.setdefault(kind.status, []).append(kind.code)
    return {status: {"description": ", ".join(titles[status]), "content": content} for status in statuses}


def problem(kind: Kind, detail: str, headers: Mapping[str, str] | None = None, **more: Any) -> Response:
    """An answer that says what was wrong. An error's own code may say more than its kind's."""
    known: dict[str, Any] = {"title": kind.title, "status": kind.status, "code": kind.code, "detail": detail}
    body = Problem(type=f"/problems/{kind.code}", **(known | more))
    text = body.model_dump_json(exclude_none=True)
    return Response(text, kind.status, headers=dict(headers or {}), media_type=MEDIA_TYPE)


def install(app: FastAPI) -> None:
    """Answer every error with a problem."""
    app.add_exception_handler(ModallabError, _known)
    app.add_exception_handler(RequestValidationError, _not_valid)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(Exception, _unexpected)


def of_error(error: ModallabError) -> Response:
    """The answer for an expected error."""
    kind = kind_of(error)
    headers = {"Retry-After": "1"} if kind.status == 503 else {}
    legal = None
    if isinstance(error, IllegalTransitionError):
        legal = tuple(word for word in error.remedy.removeprefix("legal: ").split(", ") if " " not in word)
    # On the machine itself there is a command for it; whoever asks here has the lease.
    remedy = RESET if isinstance(error, TrippedError) else error.remedy
    return problem(kind, error.what, headers, code=error.code, remedy=remedy, where=error.where, legal=legal)


async def _known(request: Request, error: Exception) -> Response:
    assert isinstance(error, ModallabError)
    if kind_of(error).status >= 500:
        LOG.warning("%s %s: %s", request.method, request.url.path, error)
    return of_error(error)


async def _not_valid(_request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    found = tuple({"where": ".".join(str(part) for part in one["loc"]), "what": _said(one)} for one in error.errors())
    remedy = "put right what `errors` names; every request and its fields stand at /docs"
    return problem(KINDS["not-valid"], f"{len(found)} of its fields cannot be taken", remedy=remedy, errors=found)


def _said(error: Mapping[str, Any]) -> str:
    if error["type"] == "union_tag_not_found":
        # As pydantic says it, only its own users understand it.
        return f"needs a field {error['ctx']['discriminator']} that says what it is"
    return str(error["msg"])


async def _http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    code = {404: "no-page", 405: "not-allowed", 413: "too-large"}.get(error.status_code, "not-valid")
    headers = {"Allow": _allowed(request)} if error.status_code == 405 else error.headers
    return problem(KINDS[code], str(error.detail), headers)


def _allowed(request: Request) -> str:
    # The router names the methods of the first route of this path; each of ours has one.
    app: FastAPI = request.app
    found: set[str] = set()
    for route in app.routes:
        if isinstance(route, Route) and route.matches(request.scope)[0] is not Match.NONE:
            found |= route.methods or set()
    return ", ".join(sorted(found))


async def _unexpected(request: Request, error: Exception) -> Response:
    number = secrets.token_hex(4)
    LOG.error("%s: %s %s failed", number, request.method, request.url.path, exc_info=error)
    return problem(KINDS["unexpected"], "an error nobody expected", where=number, remedy="look at the log")
