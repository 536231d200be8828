"""Routes whose requests may be sent twice: with the same `Idempotency-Key` they are done once."""

from collections.abc import Callable, Coroutine
from typing import Annotated, Any

from fastapi import Header, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.routing import APIRoute

from modallab.core.errors import ModallabError
from modallab.service.api.problems import of_error
from modallab.service.api.request_context import OPERATOR
from modallab.service.records.idempotency import Answer, Keys

HEADER = "Idempotency-Key"
KEPT = ("location", "etag", "content-type", "retry-after")
Handler = Callable[[Request], Coroutine[Any, Any, Response]]


def idempotency_key(
    key: Annotated[
        str | None,
        Header(
            alias=HEADER,
            min_length=8,
            max_length=128,
            pattern=r"^[\x21-\x7e]+$",
            description="Made anew for each request; sent again with the same request, it gives the first answer.",
        ),
    ] = None,
) -> str | None:
    """The key, for the OpenAPI document; `IdempotentRoute` looks at it."""
    return key


class IdempotentRoute(APIRoute):
    """Looks the key up before the route is called, and keeps the answer after it."""

    def get_route_handler(self) -> Handler:
        """The route's handler, with the look-up around it."""
        handler = super().get_route_handler()

        async def once(request: Request) -> Response:
            key = request.headers.get(HEADER)
            if request.method != "POST" or key is None or not 8 <= len(key) <= 128:
                return await handler(request)
            return await _once(request, key, handler)

        return once


async def _once(request: Request, key: str, handler: Handler) -> Response:
    keys: Keys = request.app.state.service.keys
    # Who asks is kept with what he did, so it is part of the request; the lease is not, since it may be another by now.
    operator = repr(request.headers.get(OPERATOR)).encode()
    asked = b"\0".join([request.method.encode(), request.url.path.encode(), operator, await request.body()])
    before = await run_in_threadpool(keys.claim, key, asked)
    if before is not None:
        return Response(before.body, before.status, headers=before.headers | {"Idempotency-Replayed": "true"})
    try:
        response = await handler(request)
    except ModallabError as error:
        response = of_error(error)
    except BaseException:
        await run_in_threadpool(keys.forget, key)
        raise
    if response.status_code < 400:
        headers = {name: response.headers[name] for name in KEPT if name in response.headers}
        answer = Answer(response.status_code, headers, bytes(response.body).decode())
        await run_in_threadpool(keys.keep, key, answer)
    else:
        await run_in_threadpool(keys.forget, key)
    return response
