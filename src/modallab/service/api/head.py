"""HEAD is GET without the body, for every address."""

from starlette.types import ASGIApp, Message, Receive, Scope, Send


class HeadAsGet:
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
