"""Who may ask, and how much: looked at before any route; and logging in with a browser."""

import secrets
from collections.abc import Iterable
from typing import Annotated

from fastapi import Request, Response
from pydantic import Field
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from modallab.core.frozen import Frozen
from modallab.service.api.problems import kinds, problem
from modallab.service.api.router import OPEN, make_router
from modallab.service.records.sessions import Sessions

COOKIE = "modallab_session"
OPEN_PATHS = frozenset({"/health", "/api/v1/session", "/", "/docs", "/openapi.json", "/asyncapi.json"})
OPEN_FOLDERS = ("/docs/", "/problems/", "/page/")
FILES = "/api/v1/imports"
"""The one address where a body is a file."""
TRUSTED = "modallab.trusted"
"""In the scope of a request that carried the token."""
SAFE = frozenset({"GET", "HEAD", "OPTIONS"})


class Guard:
    """Looks at Host, Origin, token and the size of the body."""

    def __init__(
        self,
        app: ASGIApp,
        token: str,
        sessions: Sessions,
        hosts: Iterable[str],
        body_bytes: int,
        origins: Iterable[str] = (),
        file_bytes: int = 0,
    ) -> None:
        self._app = app
        self._token = token.encode()
        self._sessions = sessions
        self._hosts = frozenset(hosts)
        self._body_bytes, self._file_bytes = body_bytes, file_bytes
        self._origins = frozenset(origins)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what may be asked."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        rejected = self._rejection(connection)
        if rejected is not None:
            await _reject(scope, receive, send, *rejected)
            return
        if self._knows_token(connection.headers, connection):
            scope[TRUSTED] = True
        limited = self._limited(scope, receive)
        if scope["type"] == "http" and TRUSTED not in scope and scope["method"] not in SAFE:
            # Whoever has no token gets no work done before his request is whole.
            limited = await _whole(limited)
        await self._app(scope, limited, send)

    def _rejection(self, connection: HTTPConnection) -> tuple[str, str] | None:
        headers, path = connection.headers, connection.scope["path"]
        host = headers.get("host", "")
        if _name(host) not in self._hosts:
            return "foreign-host", f"this service is not {host!r}"
        origin = headers.get("origin")
        changes = connection.scope["type"] == "websocket" or connection.scope["method"] not in SAFE
        ours = origin is None or origin in self._origins or origin.partition("://")[2] == host
        if changes and not ours:
            return "foreign-origin", f"sent by a page of {origin!r}"
        most = self._most(path)
        if int(_digits(headers.get("content-length", "0"))) > most:
            return "too-large", f"more than {most} bytes"
        if path in OPEN_PATHS or path.startswith(OPEN_FOLDERS) or self._knows_token(headers, connection):
            return None
        return "token-needed", "the request carries no token, or a wrong one"

    def _most(self, path: str) -> int:
        return self._file_bytes if path == FILES else self._body_bytes

    def _knows_token(self, headers: Headers, connection: HTTPConnection) -> bool:
        kind, _, sent = headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer" and secrets.compare_digest(sent.strip().encode(), self._token):
            return True
        return self._sessions.knows(connection.cookies.get(COOKIE, ""))

    def _limited(self, scope: Scope, receive: Receive) -> Receive:
        if scope["type"] != "http":
            return receive
        left = most = self._most(scope["path"])

        async def limited() -> Message:
            nonlocal left
            message = await receive()
            left -= len(message.get("body", b""))
            if left < 0:
                # FastAPI lets only this kind through while it reads a body.
                raise HTTPException(413, f"more than {most} bytes")
            return message

        return limited


async def _whole(receive: Receive) -> Receive:
    """What was received to the end of the body, or to what broke it off."""
    messages: list[Message | Exception] = []
    while True:
        try:
            message = await receive()
        except HTTPException as error:
            messages.append(error)
            break
        messages.append(message)
        if message["type"] != "http.request" or not message.get("more_body", False):
            break
    waiting = iter(messages)

    async def again() -> Message:
        message = next(waiting, None)
        if isinstance(message, Exception):
            raise message
        return message if message is not None else await receive()

    return again


async def _reject(scope: Scope, receive: Receive, send: Send, code: str, detail: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": detail[:100]})
        return
    kind = kinds()[code]
    headers = {"WWW-Authenticate": "Bearer"} if kind.status == 401 else {}
    await problem(kind, detail, headers, remedy=kind.meaning)(scope, receive, send)


def _name(host: str) -> str:
    if host.startswith("["):
        return host[1:].partition("]")[0]
    return host.partition(":")[0].lower()


def _digits(text: str) -> str:
    return text if text.isascii() and text.isdigit() and len(text) < 19 else "0"


router = make_router("session")


class Login(Frozen):
    """The token of the service.

    Attributes:
        token: it.
    """

    token: Annotated[str, Field(max_length=200)]


@router.post("/session", status_code=204, response_class=Response, openapi_extra=OPEN)
def log_in(login: Login, request: Request) -> Response:
    """Get a cookie that stands for the token; no script of a page can read it, and no other site can send it."""
    token: str = request.app.state.token
    if not secrets.compare_digest(login.token.encode(), token.encode()):
        kind = kinds()["token-needed"]
        return problem(kind, "the token is wrong", {"WWW-Authenticate": "Bearer"}, remedy=kind.meaning)
    sessions: Sessions = request.app.state.sessions
    response = Response(status_code=204)
    secure = request.url.scheme == "https"
    response.set_cookie(COOKIE, sessions.begin(), httponly=True, samesite="strict", secure=secure, path="/")
    return response


@router.delete("/session", status_code=204, response_class=Response, openapi_extra=OPEN)
def log_out(request: Request) -> Response:
    """Give the cookie back: it stands for nothing any more, whoever may have a copy."""
    sessions: Sessions = request.app.state.sessions
    sessions.end(request.cookies.get(COOKIE, ""))
    response = Response(status_code=204)
    response.delete_cookie(COOKIE, path="/")
    return response
