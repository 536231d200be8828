"""Logging in with a browser, which cannot send a header with everything."""

import secrets
from typing import Annotated

from fastapi import Request, Response
from pydantic import Field

from modallab.core.frozen import Frozen
from modallab.service.api.guard import COOKIE, session_of
from modallab.service.api.openapi_document import OPEN
from modallab.service.api.problem_kinds import KINDS
from modallab.service.api.problems import problem
from modallab.service.api.router import make_router

router = make_router("session")


class Login(Frozen):
    """The token of the service."""

    token: Annotated[str, Field(max_length=200)]


@router.post("/session", status_code=204, response_class=Response, openapi_extra=OPEN)
def log_in(login: Login, request: Request) -> Response:
    """Get a cookie that stands for the token; no script of a page can read it, and no other site can send it."""
    token: str = request.app.state.token
    if not secrets.compare_digest(login.token.encode(), token.encode()):
        kind = KINDS["token-needed"]
        return problem(kind, "the token is wrong", {"WWW-Authenticate": "Bearer"}, remedy=kind.meaning)
    response = Response(status_code=204)
    secure = request.url.scheme == "https"
    response.set_cookie(COOKIE, session_of(token), httponly=True, samesite="strict", secure=secure, path="/")
    return response


@router.delete("/session", status_code=204, response_class=Response, openapi_extra=OPEN)
def log_out() -> Response:
    """Give the cookie back."""
    response = Response(status_code=204)
    response.delete_cookie(COOKIE, path="/")
    return response
