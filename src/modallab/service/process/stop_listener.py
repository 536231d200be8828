"""The emergency stop's own small listener, in the supervisor: it works when the REST process is slow or dead."""

import json
import logging
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import cast
from urllib.parse import parse_qs, urlsplit

from modallab.core.errors import ModallabError
from modallab.service.errors import NotFoundError

LOG = logging.getLogger(__name__)
PATH = "/emergency-stop"
PATIENCE_S = 5.0
POLICY = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'"
# The form goes to the page's own address, with the rig and the operator that may stand there.
PAGE = """<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content="width=device-width">
<title>Emergency stop</title>
<style>body{font:18px/1.5 system-ui,sans-serif;text-align:center;margin:2em}
button{font:bold 40px system-ui,sans-serif;width:7em;height:7em;border-radius:50%;border:12px solid #fc0;
background:#c00;color:#fff;margin:1em}</style>
<h1>Emergency stop</h1><form method=post><button>STOP</button></form>
<p>Brings the outputs to 0 V and latches the rigs until they are reset.
It is not a safety-rated stop: keep a switch in your hand.</p></html>
"""
Stop = Callable[[str | None, str, str], tuple[str, ...]]


class StopListener:
    """Hears `POST /emergency-stop?rig=ID&operator=NAME`; without a rig all of them are stopped.

    It asks for no lease and no token: whoever reaches it may stop. Who may reach it is a matter of its address.
    """

    def __init__(self, host: str, port: int, stop: Stop) -> None:
        """Listen.

        Raises:
            OSError: the address is taken.
        """
        self._server = _Server((host, port), stop)
        self.port: int = self._server.server_address[1]
        Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.1}, name="stop", daemon=True).start()

    def close(self) -> None:
        """Hear no more."""
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 128

    def __init__(self, address: tuple[str, int], stop: Stop) -> None:
        self.stop = stop
        super().__init__(address, _Handler)


class _Handler(BaseHTTPRequestHandler):
    timeout = PATIENCE_S
    server_version = "modallab"
    sys_version = ""

    def do_POST(self) -> None:
        """Stop."""
        address = urlsplit(self.path)
        if address.path != PATH:
            self._say(404, {"detail": f"POST {PATH}"})
        elif self._is_of_another_site():
            self._say(403, {"detail": "a page of another site sent this"})
        else:
            asked = parse_qs(address.query)
            self._stop(asked.get("rig", [None])[0], asked.get("operator", ["unknown"])[0][:80])

    def do_GET(self) -> None:
        """Nothing is stopped by looking; a browser gets the button for it."""
        if urlsplit(self.path).path == PATH:
            self._send(200, "text/html; charset=utf-8", PAGE.encode())
        else:
            self._say(404, {"detail": f"POST {PATH}"})

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Into the service's log."""
        LOG.info("stop listener: %s", format % args)

    def _is_of_another_site(self) -> bool:
        origin = self.headers.get("Origin")
        name = (self.headers.get("Host") or "").rpartition(":")[0]
        return origin is not None and urlsplit(origin).hostname != name.strip("[]")

    def _stop(self, rig: str | None, operator: str) -> None:
        server = cast("_Server", self.server)
        try:
            stopped = server.stop(rig, "by the stop listener", operator)
        except NotFoundError as error:
            self._say(404, {"detail": error.what, "remedy": error.remedy, "code": error.code})
        except ModallabError as error:
            self._say(500, {"detail": error.what, "remedy": error.remedy, "code": error.code})
        else:
            self._say(200, {"stopped": list(stopped)})

    def _say(self, status: int, content: dict[str, object]) -> None:
        self._send(status, "application/json", json.dumps(content).encode())

    def _send(self, status: int, kind: str, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        # No page of another site may lay its own content over the button.
        self.send_header(
            "Content-Security-Policy", "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'"
        )
        self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(body)
