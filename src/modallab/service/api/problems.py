"""Errors as problem details (RFC 9457): every kind, and the answer that says what was wrong and what to do."""

import logging
import secrets
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.routing import Match

from modallab.acquisition.monitor.run_states import IllegalTransitionError
from modallab.acquisition.process.trip import TrippedError
from modallab.core.documents.pages import ProblemDetails
from modallab.core.errors import DatabaseLostError, ModallabError
from modallab.core.field_errors import is_short_by_wrong_entries

LOG = logging.getLogger(__name__)
MEDIA_TYPE = "application/problem+json"
RESET = "check the bench, then POST to the rig's `reset`, with its lease"
Responses = dict[int | str, dict[str, Any]]


@dataclass(frozen=True, slots=True)
class ProblemKind:
    """A kind of problem.

    Attributes:
        code: for programs; the page of the kind is /problems/<code>.
        status: HTTP status.
        title: in a few words.
        meaning: what it says and what to do.
    """

    code: str
    status: int
    title: str
    meaning: str


OF_REQUEST: tuple[ProblemKind, ...] = (
    ProblemKind(
        "not-valid",
        422,
        "The request is not valid",
        "A field is missing, unknown or out of range; `errors` names each.",
    ),
    ProblemKind(
        "not-allowed",
        405,
        "This method is not allowed here",
        "The header `Allow` lists the allowed methods.",
    ),
    ProblemKind(
        "no-page",
        404,
        "There is no resource at this address",
        "/openapi.json lists all addresses.",
    ),
    ProblemKind(
        "token-needed",
        401,
        "A token is needed",
        "Send the header `Authorization: Bearer TOKEN`, or log in at /api/v1/session. The service names the file of "
        "the token when it starts.",
    ),
    ProblemKind(
        "foreign-host",
        403,
        "The service does not have this host name",
        "The header `Host` names a host that the setting `hosts` does not list.",
    ),
    ProblemKind(
        "foreign-origin",
        403,
        "A page of another site sent this request",
        "The header `Origin` is not that of this service.",
    ),
    ProblemKind(
        "too-large",
        413,
        "The body is too large",
        "The limit is the setting `body_bytes`.",
    ),
    ProblemKind(
        "unexpected",
        500,
        "The service failed",
        "An unexpected error. The log has it, under the number in `where`.",
    ),
)


def problem_kinds() -> dict[str, ProblemKind]:
    """All kinds by code: those of a request, and those that error classes declare as their `http`."""
    found = {kind.code: kind for kind in OF_REQUEST} | {
        cls.code: _declared_kind(cls) for cls in _declaring_classes(ModallabError)
    }
    return dict(sorted(found.items()))


def kind_of(error: ModallabError) -> ProblemKind:
    """The kind of an error: that of the nearest class that declares one."""
    return _declared_kind(next(cls for cls in type(error).__mro__ if "http" in vars(cls)))


def _declared_kind(cls: type[ModallabError]) -> ProblemKind:
    return ProblemKind(cls.code, *cls.http)


def _declaring_classes(cls: type[ModallabError]) -> Iterator[type[ModallabError]]:
    if "http" in vars(cls):
        yield cls
    for below in cls.__subclasses__():
        yield from _declaring_classes(below)


def documented_responses(*statuses: int) -> Responses:
    """What a route may answer with besides its result, for the OpenAPI document."""
    content: dict[str, Any] = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}}
    titles: dict[int, list[str]] = {}
    for kind in problem_kinds().values():
        titles.setdefault(kind.status, []).append(kind.code)
    return {status: {"description": ", ".join(titles[status]), "content": content} for status in statuses}


def problem_response(kind: ProblemKind, detail: str, headers: Mapping[str, str] | None = None, **more: Any) -> Response:
    """An answer that says what was wrong. An error's own code may say more than its kind's."""
    known: dict[str, Any] = {"title": kind.title, "status": kind.status, "code": kind.code, "detail": detail}
    body = ProblemDetails(type=f"/problems/{kind.code}", **(known | more))
    text = body.model_dump_json(exclude_none=True)
    return Response(text, kind.status, headers=dict(headers or {}), media_type=MEDIA_TYPE)


def install_handlers(app: FastAPI) -> None:
    """Answer every error with a problem."""
    app.add_exception_handler(ModallabError, _on_known_error)
    app.add_exception_handler(RequestValidationError, _not_valid)
    app.add_exception_handler(HTTPException, _on_http_error)
    app.add_exception_handler(ClientDisconnect, _on_disconnect)
    app.add_exception_handler(Exception, _on_unexpected_error)


def response_of_error(error: ModallabError) -> Response:
    """The answer for an expected error."""
    kind = kind_of(error)
    headers = {"Retry-After": "1"} if kind.status == 503 else {}
    legal = None
    if isinstance(error, IllegalTransitionError):
        legal = tuple(word for word in error.remedy.removeprefix("legal: ").split(", ") if " " not in word)
    # Where the server stands is for the log.
    where = "" if isinstance(error, DatabaseLostError) else error.where
    # On the machine itself there is a command for it; whoever asks here has the lease.
    remedy = RESET if isinstance(error, TrippedError) else error.remedy
    return problem_response(kind, error.what, headers, code=error.code, remedy=remedy, where=where, legal=legal)


async def _on_known_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, ModallabError)
    if kind_of(error).status >= 500:
        LOG.warning("%s %s: %s", request.method, request.url.path, error)
    return response_of_error(error)


async def _not_valid(_request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    details = error.errors()
    found = tuple(
        {"where": ".".join(str(part) for part in one["loc"]), "what": _detail_of_error(one)}
        for one in details
        if not is_short_by_wrong_entries(one, details)
    )
    remedy = "correct the fields in `errors`; /docs describes every request and its fields"
    return problem_response(
        problem_kinds()["not-valid"], f"{len(found)} of its fields are not valid", remedy=remedy, errors=found
    )


def _detail_of_error(error: Mapping[str, Any]) -> str:
    if error["type"] == "union_tag_not_found":
        # As pydantic says it, only its own users understand it.
        return f"needs a field {error['ctx']['discriminator']} with its kind"
    return str(error["msg"])


async def _on_http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    code = {404: "no-page", 405: "not-allowed", 413: "too-large"}.get(error.status_code, "not-valid")
    headers = {"Allow": _allowed_methods(request)} if error.status_code == 405 else error.headers
    kind = problem_kinds()[code]
    return problem_response(kind, str(error.detail), headers, remedy=kind.meaning)


def _allowed_methods(request: Request) -> str:
    # The router names the methods of the first route of this path; each of ours has one.
    found: set[str] = set()
    for route in request.app.state.routes:
        if route.matches(request.scope)[0] is not Match.NONE:
            found |= route.methods
    return ", ".join(sorted(found | ({"HEAD"} if "GET" in found else set())))


async def _on_disconnect(_request: Request, _error: Exception) -> Response:
    # Whoever disconnected in the middle of a body reads no answer, and is no fault of the service to be logged.
    return Response(status_code=400)


async def _on_unexpected_error(request: Request, error: Exception) -> Response:
    number = secrets.token_hex(4)
    LOG.error("%s: %s %s failed", number, request.method, request.url.path, exc_info=error)
    return problem_response(
        problem_kinds()["unexpected"], "an unexpected error", where=number, remedy="look at the log"
    )
