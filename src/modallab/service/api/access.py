"""Who may ask, and how much, looked at before any route; what a route needs: a role, a rig, a lease of its caller."""

from collections.abc import Iterable
from typing import Any

from fastapi import Request
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from modallab.core.documents.users import RANK, CallerView, Role
from modallab.core.errors import UnknownJobError
from modallab.service.api.problems import problem_kinds, problem_response
from modallab.service.api.request_context import CALLER, LEASE, caller_of
from modallab.service.context import Service
from modallab.service.errors import LeaseNeededError, NotFoundError, RoleNeededError
from modallab.service.records.sessions import BrowserSessions
from modallab.service.records.users import ValidTokens

COOKIE = "modallab_session"
OPEN_PATHS = frozenset({"/health", "/api/v1/session", "/login", "/", "/docs", "/openapi.json", "/asyncapi.json"})
OPEN_FOLDERS = ("/docs/", "/problems/", "/page/", "/manual/")
FILES = "/api/v1/imports"
"""The one address where a body is a file."""
TRUSTED = "modallab.trusted"
"""In the scope of a request that carried the token."""
SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
_ROLE = "x-role"
_ANY_RIG = "x-any-rig"
_READS = frozenset({"GET", "HEAD"})


class AccessGuard:
    """Looks at Host, Origin, token and the size of the body."""

    def __init__(
        self,
        app: ASGIApp,
        callers: ValidTokens,
        sessions: BrowserSessions,
        hosts: Iterable[str],
        body_bytes: int,
        origins: Iterable[str] = (),
        file_bytes: int = 0,
    ) -> None:
        self._app = app
        self._callers = callers
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
        caller = self._caller(connection)
        rejected = self._rejection(connection, caller)
        if rejected is not None:
            await _send_rejection(scope, receive, send, *rejected)
            return
        if caller is not None:
            scope[TRUSTED], scope[CALLER] = True, caller
        limited = self._limited(scope, receive)
        if scope["type"] == "http" and TRUSTED not in scope and scope["method"] not in SAFE:
            # Whoever has no token gets no work done before his request is whole.
            limited = await _whole_body(limited)
        await self._app(scope, limited, send)

    def _rejection(self, connection: HTTPConnection, caller: CallerView | None) -> tuple[str, str] | None:
        headers, path = connection.headers, connection.scope["path"]
        host = headers.get("host", "")
        if _host_name(host) not in self._hosts:
            return "foreign-host", f"this service is not {host!r}"
        origin = headers.get("origin")
        changes = connection.scope["type"] == "websocket" or connection.scope["method"] not in SAFE
        ours = origin is None or origin in self._origins or origin.partition("://")[2] == host
        if changes and not ours:
            return "foreign-origin", f"sent by a page of {origin!r}"
        most = self._most(path)
        if int(_number_of_digits(headers.get("content-length", "0"))) > most:
            return "too-large", f"more than {most} bytes"
        if path in OPEN_PATHS or path.startswith(OPEN_FOLDERS) or caller is not None:
            return None
        return "token-needed", "the request carries no token, or a wrong one"

    def _most(self, path: str) -> int:
        return self._file_bytes if path == FILES else self._body_bytes

    def _caller(self, connection: HTTPConnection) -> CallerView | None:
        kind, _, sent = connection.headers.get("authorization", "").partition(" ")
        known = self._callers.of_token(sent.strip()) if kind.lower() == "bearer" else None
        if known is not None:
            return known
        token = self._sessions.token_of(connection.cookies.get(COOKIE, ""))
        return None if token is None else self._callers.of_id(token)

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


async def _whole_body(receive: Receive) -> Receive:
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


async def _send_rejection(scope: Scope, receive: Receive, send: Send, code: str, detail: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": detail[:100]})
        return
    kind = problem_kinds()[code]
    headers = {"WWW-Authenticate": "Bearer"} if kind.status == 401 else {}
    await problem_response(kind, detail, headers, remedy=kind.meaning)(scope, receive, send)


def _host_name(host: str) -> str:
    if host.startswith("["):
        return host[1:].partition("]")[0]
    return host.partition(":")[0].lower()


def _number_of_digits(text: str) -> str:
    return text if text.isascii() and text.isdigit() and len(text) < 19 else "0"


def role_needed(role: Role, *, any_rig: bool = False) -> dict[str, Any]:
    """For the `openapi_extra` of a route that needs another role than is usual for its method.

    With `any_rig` it may be asked of every rig, whatever rigs the token is for.
    """
    return {_ROLE: role} | ({_ANY_RIG: True} if any_rig else {})


def declared_role(methods: set[str], extra: dict[str, Any]) -> dict[str, Any]:
    """What stands of a route's role in the document: who only reads is an observer, unless the route says otherwise."""
    if extra.get("security") == []:
        return extra
    role = extra.get(_ROLE) or ("observer" if methods <= _READS else "operator")
    # OpenAPI 3.1 names roles here for schemes that have no scopes.
    return extra | {_ROLE: role, "security": [{"token": [role]}, {"session": [role]}]}


def require_role(request: Request, extra: dict[str, Any]) -> bool:
    """Reject who may not ask this, as far as is known without the database; whether `require_own_rig` is needed too.

    Raises:
        RoleNeededError: the caller's role is too low.
    """
    role: Role | None = extra.get(_ROLE)
    if role is None:
        return False
    caller = caller_of(request)
    if RANK[caller.role] < RANK[role]:
        raise RoleNeededError(
            f"this needs the role {role}; {caller.name or 'this token'} is {caller.role}",
            remedy="ask somebody with that role, or an admin for another token",
        )
    return role != "observer" and bool(caller.rigs or caller.name)


def require_own_rig(request: Request, extra: dict[str, Any]) -> None:
    """Reject who works at another rig than the token is for, or with the lease of another.

    Raises:
        RoleNeededError: the token is for other rigs.
        LeaseNeededError: the lease that was sent is somebody else's.
        StorageError: it cannot be looked up.
    """
    caller = caller_of(request)
    service: Service = request.app.state.service
    if caller.rigs and _ANY_RIG not in extra:
        named = request.path_params if request.path_params else dict(request.query_params)
        require_rig(caller, _rig_of(service, named))
    _require_own_lease(service, caller, request.headers.get(LEASE))


def require_rig(caller: CallerView, rig: str | None) -> None:
    """Reject who may not work at a rig.

    Raises:
        RoleNeededError: the token is for other rigs.
    """
    if caller.rigs and rig is not None and rig not in caller.rigs:
        raise RoleNeededError(
            f"this token is for {', '.join(caller.rigs)}, not for {rig}",
            where=rig,
            remedy="ask an admin for a token for this rig",
        )


def _require_own_lease(service: Service, caller: CallerView, lease: str | None) -> None:
    # Who has the service's own token says himself who he is.
    if not lease or not caller.name:
        return
    owner = service.leases.owner(lease)
    if owner is not None and owner != caller.name:
        raise LeaseNeededError(f"this lease is {owner}'s", remedy="take the lease yourself")


def _rig_of(service: Service, named: dict[str, Any]) -> str | None:
    """The rig that an address concerns; None if it concerns none, or names what is not there."""
    if "rig" in named:
        return str(named["rig"])
    try:
        if "run" in named:
            entry = service.repository.run_entry(str(named["run"]))
            return None if entry is None else entry.rig
        campaign = named.get("campaign") or service.repository.campaign_of_job(str(named.get("job", "")))
        return service.repository.campaign(str(campaign)).rig if campaign else None
    except (NotFoundError, UnknownJobError):
        return None
