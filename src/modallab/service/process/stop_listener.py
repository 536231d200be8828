"""The emergency stop's own small listener, in the supervisor: it works when the REST process is slow or dead."""

import json
import logging
import socket
import ssl
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock, Thread
from typing import Any, cast
from urllib.parse import parse_qs, urlsplit

from modallab.core.errors import ModallabError
from modallab.core.settings import LOOPBACK
from modallab.service.errors import NotFoundError

LOG = logging.getLogger(__name__)
PATH = "/emergency-stop"
PATIENCE_S = 5.0
"""Until a request must be there as a whole."""
AT_ONCE = 100
"""Connections that may be waited for; then the one that has been waited for longest gives way."""
BODY_BYTES = 1 << 16
HANDSHAKE = b"\x16"
"""The first byte of TLS; no method of HTTP begins with it."""
DRAIN_S = 1.0
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

    def __init__(
        self, host: str, port: int, stop: Stop, names: Iterable[str] = (), tls: ssl.SSLContext | None = None
    ) -> None:
        """Listen.

        Args:
            host: address to listen on.
            port: 0 for any free one.
            stop: called with the rig (None: all), the reason and the operator; returns the rigs that were stopped.
            names: the service is known by: pages of these hosts may stop it, whatever their port.
            tls: to speak TLS with whoever begins with it; plain HTTP stops all the same.

        Raises:
            OSError: the address is taken.
        """
        self._server = _Server((host, port), stop, frozenset({*LOOPBACK, host, *(name.lower() for name in names)}), tls)
        self.port: int = self._server.server_address[1]
        Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.1}, name="stop", daemon=True).start()

    def close(self) -> None:
        """Hear no more."""
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 1024

    def __init__(self, address: tuple[str, int], stop: Stop, names: frozenset[str], tls: ssl.SSLContext | None) -> None:
        self.stop = stop
        self.tls = tls
        self.names = names
        self._waited_for: dict[socket.socket, float] = {}
        self._lock = Lock()
        if ":" in address[0]:
            self.address_family = socket.AF_INET6
        super().__init__(address, _Handler)

    def process_request(self, request: Any, client_address: Any) -> None:
        with self._lock:
            if len(self._waited_for) >= AT_ONCE:
                self._drop(next(iter(self._waited_for)))
            self._waited_for[request] = time.monotonic()
        super().process_request(request, client_address)

    def service_actions(self) -> None:
        # A time-out of each read is not enough: whoever sends a byte now and then would hold a thread for ever.
        limit = time.monotonic() - PATIENCE_S
        with self._lock:
            for late in [request for request, since in self._waited_for.items() if since < limit]:
                self._drop(late)

    def secured(self, request: socket.socket, secure: ssl.SSLSocket) -> None:
        """From now on it is read and written by another socket."""
        with self._lock:
            since = self._waited_for.pop(request, None)
            if since is not None:
                self._waited_for[secure] = since

    def arrived(self, request: socket.socket) -> None:
        """The request is there: from now on the client waits for us."""
        with self._lock:
            self._waited_for.pop(request, None)

    def shutdown_request(self, request: Any) -> None:
        self.arrived(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        LOG.debug("stop listener: %s disconnected", client_address, exc_info=True)

    def _drop(self, request: socket.socket) -> None:
        del self._waited_for[request]
        with suppress(OSError):
            request.shutdown(socket.SHUT_RDWR)


class _Handler(BaseHTTPRequestHandler):
    timeout = PATIENCE_S
    server_version = "modallab"
    sys_version = ""

    def setup(self) -> None:
        """As the library; with TLS, if that is what the first byte begins."""
        tls, plain = self._ours.tls, self.request
        if tls is not None:
            plain.settimeout(PATIENCE_S)
            if plain.recv(1, socket.MSG_PEEK) == HANDSHAKE:
                self.request = tls.wrap_socket(plain, server_side=True, do_handshake_on_connect=False)
                self._ours.secured(plain, self.request)
                self.request.do_handshake()
        super().setup()

    def finish(self) -> None:
        """As the library, which closes the socket that came."""
        super().finish()
        self._ours.shutdown_request(self.request)

    def do_POST(self) -> None:
        """Stop."""
        self._arrived()
        address = urlsplit(self.path)
        if address.path != PATH:
            self._say(404, {"detail": f"POST {PATH}"})
        elif self._is_of_another_site():
            self._say(403, {"detail": "a page of another site sent this", "remedy": "name its host in MODALLAB_HOSTS"})
        else:
            asked = parse_qs(address.query)
            self._stop(asked.get("rig", [None])[0], asked.get("operator", ["unknown"])[0][:80])

    def do_GET(self) -> None:
        """Nothing is stopped by looking; a browser gets the button for it."""
        self._arrived()
        if urlsplit(self.path).path == PATH:
            self._send(200, "text/html; charset=utf-8", PAGE.encode())
        else:
            self._say(404, {"detail": f"POST {PATH}"})

    def do_HEAD(self) -> None:
        """As GET, without the page."""
        self.do_GET()

    def do_OPTIONS(self) -> None:
        """What a page of another port may send; browsers ask before they do."""
        self._arrived()
        self._send(204, "text/plain", b"")

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Only for whoever looks for an error: anyone may ask here, and a stop waits for no log."""
        LOG.debug("stop listener: %s", format % args)

    @property
    def _ours(self) -> "_Server":
        return cast("_Server", self.server)

    def _arrived(self) -> None:
        self._ours.arrived(self.connection)

    def _is_of_another_site(self) -> bool:
        origin = self.headers.get("Origin")
        if origin is None:
            return False
        # A proxy may have put its own words for the Host that the page knows.
        hosts = (self.headers.get(name) or "" for name in ("Host", "X-Forwarded-Host"))
        return _name_of_address(origin) not in self._ours.names | {
            _name_of_address(f"//{host}") for host in hosts if host
        }

    def _stop(self, rig: str | None, operator: str) -> None:
        try:
            stopped = self._ours.stop(rig, "by the stop listener", operator)
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
        headers = {"Content-Type": kind, "Content-Length": str(len(body)), "Cache-Control": "no-store"}
        # No page of another site may lay its own content over the button.
        headers |= {"Content-Security-Policy": POLICY, "Vary": "Origin", "Connection": "close"}
        for name, value in (headers | self._for_pages()).items():
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)
        self._drain()

    def _for_pages(self) -> dict[str, str]:
        origin = self.headers.get("Origin")
        if origin is None or self._is_of_another_site():
            return {}
        may = {"Methods": "GET, HEAD, POST, OPTIONS", "Headers": "Content-Type", "Private-Network": "true"}
        return {"Access-Control-Allow-Origin": origin} | {f"Access-Control-Allow-{k}": v for k, v in may.items()}

    def _drain(self) -> None:
        # A body that nobody read would have the system reset the connection, and the answer be lost with it.
        length = self.headers.get("Content-Length") or ""
        if length.isascii() and length.isdigit() and len(length) < 9:
            with suppress(OSError):
                self.connection.settimeout(DRAIN_S)
                self.rfile.read(min(int(length), BODY_BYTES))


def _name_of_address(address: str) -> str:
    try:
        return urlsplit(address).hostname or ""
    except ValueError:
        return ""
