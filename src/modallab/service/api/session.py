"""Logging in with a browser, by a token or by a link that works once, and who one is then."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import RedirectResponse
from pydantic import Field

from modallab.core.documents.users import CallerView, LoginLink
from modallab.core.frozen import Frozen
from modallab.service.api.access import COOKIE, role_needed
from modallab.service.api.problems import documented_responses, problem_kinds, problem_response
from modallab.service.api.request_context import CallerOf
from modallab.service.api.router import OPEN, make_router
from modallab.service.records.sessions import BrowserSessions, make_link
from modallab.service.records.users import ValidTokens

router = make_router("session")
pages = APIRouter(include_in_schema=False)


class LoginRequest(Frozen):
    """Credentials of a user.

    Attributes:
        token: the service's own token, or a user's.
    """

    token: Annotated[str, Field(max_length=200)]


@router.post("/session", status_code=204, response_class=Response, openapi_extra=OPEN)
def log_in(login: LoginRequest, request: Request) -> Response:
    """Get a cookie that replaces the token; scripts cannot read it, and other sites cannot send it."""
    callers: ValidTokens = request.app.state.callers
    caller = callers.of_token(login.token)
    if caller is None:
        return _wrong_token("the token is wrong")
    response = Response(status_code=204)
    _begin_session(request, response, caller.token)
    return response


@router.delete("/session", status_code=204, response_class=Response, openapi_extra=OPEN)
def log_out(request: Request) -> Response:
    """Log out: the cookie becomes invalid, including all copies."""
    sessions: BrowserSessions = request.app.state.sessions
    sessions.end(request.cookies.get(COOKIE, ""))
    response = Response(status_code=204)
    response.delete_cookie(COOKIE, path="/")
    return response


@router.get("/me")
def show_caller(caller: CallerOf) -> CallerView:
    """The user of the token or cookie in the request."""
    return caller


@router.post(
    "/login-links", status_code=201, responses=documented_responses(507), openapi_extra=role_needed("observer")
)
def make_login_link(caller: CallerOf, request: Request, response: Response) -> LoginLink:
    """Get an address that logs a browser in as yourself, once, within ten minutes."""
    response.headers["Cache-Control"] = "no-store"
    callers: ValidTokens = request.app.state.callers
    path, until = make_link(request.app.state.service.engine, caller.token, callers.cookie_key(caller.token))
    return LoginLink(path=path, expires_utc=until)


@pages.get("/login")
def follow_link(key: Annotated[str, Query(max_length=200)], request: Request) -> Response:
    """Log the browser in that opened a link, and lead it on."""
    if "prefetch" in request.headers.get("sec-purpose", ""):
        # Nobody has opened it yet.
        return Response(status_code=204)
    sessions: BrowserSessions = request.app.state.sessions
    token = sessions.use_link(key)
    if token is None:
        return _wrong_token("this link was used, or has expired")
    response = RedirectResponse("/", 303, headers={"Cache-Control": "no-store", "Referrer-Policy": "no-referrer"})
    _begin_session(request, response, token)
    return response


def _begin_session(request: Request, response: Response, token: str) -> None:
    sessions: BrowserSessions = request.app.state.sessions
    secure = request.url.scheme == "https"
    response.set_cookie(COOKIE, sessions.begin(token), httponly=True, samesite="strict", secure=secure, path="/")


def _wrong_token(what: str) -> Response:
    kind = problem_kinds()["token-needed"]
    return problem_response(kind, what, {"WWW-Authenticate": "Bearer"}, remedy=kind.meaning)
