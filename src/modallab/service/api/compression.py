"""Answers as gzip, for clients that accept it: no stream, and no samples, which are compact."""

import gzip
from functools import partial

from fastapi.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LEAST = 1000
"""Bytes; less goes into one packet anyway."""
LARGE = 1 << 16
"""Bytes that are compressed beside the event loop: 64 KiB take a millisecond."""
LEVEL = 1
KINDS = ("application/json", "application/problem+json", "text/html", "text/plain", "text/javascript", "text/css")


class GzipResponses:
    """Compresses the answers of an application."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on."""
        if scope["type"] != "http" or not accepts_gzip(Headers(scope=scope).get("accept-encoding", "")):
            await self._app(scope, receive, send)
            return
        head: Message | None = None

        async def compressed(message: Message) -> None:
            nonlocal head
            if message["type"] == "http.response.start" and _is_text(Headers(raw=message["headers"])):
                head = message
                return
            if head is not None:
                begun, head = head, None
                message = await _compress_body(begun, message)
                await send(begun)
            await send(message)

        await self._app(scope, receive, compressed)


def accepts_gzip(accepted: str) -> bool:
    """Whether the header `Accept-Encoding` names gzip, or anything, and does not rule it out (`q=0`)."""
    weights: dict[str, float] = {}
    for part in accepted.lower().split(","):
        name, _, weight = part.partition(";")
        try:
            weights[name.strip()] = float(weight.strip().removeprefix("q=") or 1)
        except ValueError:
            weights[name.strip()] = 0.0
    return weights.get("gzip", weights.get("*", 0.0)) > 0


def _is_text(headers: Headers) -> bool:
    kind = headers.get("content-type", "").partition(";")[0].strip()
    return kind in KINDS and "content-encoding" not in headers


async def _compress_body(head: Message, message: Message) -> Message:
    """The only part of an answer, compressed, with what the head says of it changed; a part of a stream as it is."""
    body: bytes = message.get("body", b"")
    headers = MutableHeaders(raw=head["headers"])
    headers.add_vary_header("Accept-Encoding")
    if message.get("more_body", False) or len(body) < LEAST:
        return message
    compress = partial(gzip.compress, body, LEVEL, mtime=0)
    small = compress() if len(body) < LARGE else await run_in_threadpool(compress)
    headers["Content-Encoding"], headers["Content-Length"] = "gzip", str(len(small))
    tag = headers.get("etag", "")
    if tag.startswith('"'):
        # The same document, but not the same bytes.
        headers["ETag"] = f"W/{tag}"
    return {**message, "body": small}


class HeadRequests:
    """Asks for GET, and sends the head only."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self._app(scope, receive, send)
            return
        sent = False

        async def receive_no_more() -> Message:
            # A stream has no end: it hears that nobody reads it.
            return {"type": "http.disconnect"} if sent else await receive()

        async def head(message: Message) -> None:
            nonlocal sent
            if message["type"] == "http.response.start":
                await send(message)
                await send({"type": "http.response.body", "body": b"", "more_body": False})
                sent = True

        scope["method"] = "GET"
        await self._app(scope, receive_no_more, head)
