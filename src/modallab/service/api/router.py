"""The router all resources use: one prefix, the problems any may answer with, requests with a key done once."""

import hashlib
import re
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.dependencies.models import Dependant
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from sqlalchemy import Engine, delete, insert, select, update

from modallab.core.documents.users import CallerView
from modallab.core.errors import DataError, ModallabError
from modallab.service.api.access import declared_role, require_own_rig, require_role
from modallab.service.api.problems import documented_responses, response_of_error
from modallab.service.api.request_context import CALLER, OPERATOR
from modallab.service.errors import ConflictError, MediaTypeError
from modallab.service.records.repository import key_limit, key_of_another
from modallab.storage.engine import write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import IDEMPOTENCY

HEADER = "Idempotency-Key"
KEPT = ("location", "etag", "content-type", "retry-after")
Handler = Callable[[Request], Coroutine[Any, Any, Response]]
PREFIX = "/api/v1"
ANY = (401, 403, 405, 413, 415, 422, 500, 503)
"""Statuses any route may answer with."""

OPEN: dict[str, Any] = {"security": []}
"""For routes that need no token."""


def make_router(tag: str, *, files: bool = False) -> APIRouter:
    """A router for one resource. With `files`, bodies are not held in memory, and the route checks the key itself."""
    route = RoleRoute if files else IdempotentRoute
    return APIRouter(prefix=PREFIX, tags=[tag], route_class=route, responses=documented_responses(*ANY))


@dataclass(frozen=True, slots=True)
class StoredAnswer:
    """What a request was answered with."""

    status: int
    headers: dict[str, str]
    body: str


class IdempotencyKeys:
    """Idempotency keys and the answers kept under them."""

    def __init__(self, engine: Engine, boot: str) -> None:
        """`boot` names the process that answers: what another one left unfinished will not be finished."""
        self._engine = engine
        self._boot = boot

    def claim(self, key: str, request: bytes) -> StoredAnswer | None:
        """Claim a key for a request; the answer, if it was answered within `KEY_LIFE`.

        Raises:
            IdempotencyError: the key stands for another request.
            ConflictError: the first request is still being answered.
        """
        digest = hashlib.sha256(request).hexdigest()
        row = {"key": key, "request": digest, "boot": self._boot, "headers": {}, "created_utc": utc_now()}
        with write_transaction(self._engine) as connection:
            connection.execute(delete(IDEMPOTENCY).where(IDEMPOTENCY.c.created_utc < key_limit()))
            query = select(IDEMPOTENCY).where(IDEMPOTENCY.c.key == key)
            found = connection.execute(query).mappings().one_or_none()
            if found is None:
                connection.execute(insert(IDEMPOTENCY).values(row))
                return None
            if found["request"] != digest:
                raise key_of_another()
            if found["status"] is not None:
                return StoredAnswer(found["status"], dict(found["headers"]), found["body"])
            if found["boot"] == self._boot:
                raise ConflictError(
                    "the first request with this key is still in progress", where="Idempotency-Key", remedy="ask again"
                )
            connection.execute(update(IDEMPOTENCY).where(IDEMPOTENCY.c.key == key).values(boot=self._boot))
        return None

    def keep(self, key: str, answer: StoredAnswer) -> None:
        """Keep the answer for whoever asks again."""
        values = {"status": answer.status, "headers": answer.headers, "body": answer.body}
        with write_transaction(self._engine) as connection:
            connection.execute(update(IDEMPOTENCY).where(IDEMPOTENCY.c.key == key).values(values))

    def forget(self, key: str) -> None:
        """Nothing was done: the same key may be used again."""
        with write_transaction(self._engine) as connection:
            connection.execute(delete(IDEMPOTENCY).where(IDEMPOTENCY.c.key == key))


def idempotency_key(
    key: Annotated[
        str | None,
        Header(
            alias=HEADER,
            min_length=8,
            max_length=128,
            pattern=r"^[\x21-\x7e]+$",
            description="A new key for each request; a repeated request with the same key gets the first answer.",
        ),
    ] = None,
) -> str | None:
    """The key, for the OpenAPI document; `IdempotentRoute` looks at it."""
    return key


Key = Annotated[str | None, Depends(idempotency_key)]
ONCE = [Depends(idempotency_key)]
"""For routes that make something."""


class RoleRoute(APIRoute):
    """Looks at the caller's role before the route is called."""

    def __init__(self, path: str, endpoint: Callable[..., Any], **more: Any) -> None:
        methods = {method.upper() for method in more.get("methods") or ("GET",)}
        extra = declared_role(methods, dict(more.pop("openapi_extra", None) or {}))
        super().__init__(path, endpoint, openapi_extra=extra, **more)

    def get_route_handler(self) -> Handler:
        """The route's handler, with the look-up around it."""
        handler = self.wrap_handler(super().get_route_handler())
        extra = self.openapi_extra or {}
        known = _query_names(self.dependant)

        async def asked(request: Request) -> Response:
            if require_role(request, extra):
                await run_in_threadpool(require_own_rig, request, extra)
            _require_address(request)
            _require_unpacked(request)
            _require_known(request, known)
            return await handler(request)

        return asked

    def wrap_handler(self, handler: Handler) -> Handler:
        """The handler with what else is to be done before and after it."""
        return handler


class IdempotentRoute(RoleRoute):
    """Looks at body and key before the route is called, and keeps the answer after it."""

    def wrap_handler(self, handler: Handler) -> Handler:
        """As the class says."""

        async def once(request: Request) -> Response:
            await _require_body(request)
            if request.method != "POST":
                return await handler(request)
            return await answer_once(request, await request.body(), lambda: handler(request))

        return once


_NUL = re.compile(rb"\x00|(?<!\\)(?:\\\\)*\\u0000")
_JSON = re.compile(r"application/(?:[\w.+-]+\+)?json\s*(?:;.*)?", re.IGNORECASE)


def _require_address(request: Request) -> None:
    """Reject NUL in the address or the query: not every database keeps it.

    Raises:
        DataError: there is one.
    """
    query = request.query_params.multi_items()
    if "\0" in request.url.path or any("\0" in part for pair in query for part in pair):
        raise _nul_character_error("the address")


def _query_names(dependant: Dependant) -> frozenset[str]:
    own = frozenset(field.alias for field in dependant.query_params)
    return own.union(*map(_query_names, dependant.dependencies))


def _require_known(request: Request, known: frozenset[str]) -> None:
    """Reject parameters that the route does not know: a misspelt one would be answered as if it had not been sent.

    Raises:
        RequestValidationError: names each, and those that are known.
    """
    there = f"it takes {', '.join(sorted(known))}" if known else "it takes none"
    foreign = [name for name in request.query_params if name not in known]
    if foreign:
        said = f"is no parameter of this address; {there}"
        raise RequestValidationError([{"type": "extra_forbidden", "loc": ("query", n), "msg": said} for n in foreign])


def _require_unpacked(request: Request) -> None:
    """Reject a body that is compressed, or in parts: nothing here unpacks one, and its bytes are no text.

    Raises:
        MediaTypeError: names the packing.
    """
    remedy = "send the body unpacked: the JSON, or the file"
    packed = request.headers.get("content-encoding", "identity")
    if packed.lower() != "identity":
        raise MediaTypeError(f"a body packed by {packed!r} is not accepted", where="Content-Encoding", remedy=remedy)
    kind = request.headers.get("content-type", "")
    if kind.lower().startswith("multipart/"):
        raise MediaTypeError(f"a body in parts, {kind!r}, is not accepted", where="Content-Type", remedy=remedy)


async def _require_body(request: Request) -> None:
    """Reject a body that no resource can use, before any looks at it.

    Raises:
        MediaTypeError: it does not say that it is JSON.
        DataError: it holds NUL.
    """
    if request.method not in ("POST", "PUT", "PATCH"):
        return
    body = await request.body()
    kind = request.headers.get("content-type", "")
    if body and not _JSON.fullmatch(kind):
        raise MediaTypeError(
            f"a body of the type {kind!r} is not accepted" if kind else "the body has no type",
            where="Content-Type",
            remedy="send JSON, with the header Content-Type: application/json",
        )
    if _NUL.search(body):
        raise _nul_character_error("the body")


def _nul_character_error(where: str) -> DataError:
    return DataError("contains the character NUL", where=where, remedy="leave it out")


async def answer_once(request: Request, body: bytes, answer: Callable[[], Awaitable[Response]]) -> Response:
    """The answer to a request; where its key came before with the same request, the one that was given then.

    Args:
        request: that is asked.
        body: all that makes it another request, besides method, path and caller.
        answer: answers it.

    Raises:
        IdempotencyError: the key came with another request.
        ConflictError: the first request is still being answered.
    """
    key = request.headers.get(HEADER)
    if key is None or not 8 <= len(key) <= 128:
        return await answer()
    keys: IdempotencyKeys = request.app.state.keys
    # Who asks is kept with what he did, so it is part of the request; the lease is not, since it may be another by now.
    caller: CallerView | None = request.scope.get(CALLER)
    name = caller.name if caller is not None else ""
    operator = (name or repr(request.headers.get(OPERATOR))).encode()
    asked = b"\0".join([request.method.encode(), request.url.path.encode(), operator, body])
    before = await run_in_threadpool(keys.claim, key, asked)
    if before is not None:
        return Response(before.body, before.status, headers=before.headers | {"Idempotency-Replayed": "true"})
    try:
        response = await answer()
    except ModallabError as error:
        response = response_of_error(error)
    except BaseException:
        await run_in_threadpool(keys.forget, key)
        raise
    if response.status_code < 400 and "no-store" not in response.headers.get("cache-control", ""):
        headers = {name: response.headers[name] for name in KEPT if name in response.headers}
        given = StoredAnswer(response.status_code, headers, bytes(response.body).decode())
        await run_in_threadpool(keys.keep, key, given)
    else:
        await run_in_threadpool(keys.forget, key)
    return response
