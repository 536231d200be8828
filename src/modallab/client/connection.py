"""The connection to a service: requests sent, and sent again when it breaks, and answers read."""

import secrets
import ssl
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from threading import Event as Flag
from threading import Thread
from typing import Protocol, Self, TypeVar

import httpx
from pydantic import BaseModel, ValidationError

from modallab.core.documents.pages import Page, ProblemDetails
from modallab.core.documents.rigs import Lease


class ServiceProblemError(Exception):
    """The service answered with a problem; `problem` says which, and what to do."""

    def __init__(self, problem: ProblemDetails) -> None:
        self.problem = problem
        super().__init__(problem)

    def __str__(self) -> str:
        said = f"{self.problem.title}: {self.problem.detail}"
        return f"{said}\n  what to do: {self.problem.remedy}" if self.problem.remedy else said


def require_good(response: httpx.Response) -> httpx.Response:
    """The response, if it is no problem.

    Raises:
        ServiceProblemError: it is.
    """
    if response.is_success:
        return response
    try:
        raise ServiceProblemError(ProblemDetails.model_validate_json(response.content))
    except ValidationError as error:
        # Not from the service itself, but from something in between.
        text = f"status {response.status_code} from {response.request.url}"
        unknown = ProblemDetails(
            type="", title="The service does not answer", status=response.status_code, code="", detail=text
        )
        raise ServiceProblemError(unknown) from error


Document = TypeVar("Document", bound=BaseModel)
AGAIN_S = 0.5
TRIES = 5
_BROKEN = (httpx.ConnectError, httpx.ReadError, httpx.WriteError, httpx.RemoteProtocolError)


class RenewedLease(Protocol):
    """A lease, renewed or not."""

    @property
    def id(self) -> str:
        """What the service wants to see with every command."""
        ...


class Connection:
    """Requests to one service. What it rejects is a `ServiceProblemError`."""

    def __init__(
        self, url: str, token: str, operator: str = "", timeout_s: float = 30.0, ca: Path | None = None
    ) -> None:
        """Prepare; nothing is asked yet.

        Args:
            url: of the service.
            token: its token, or that of a user.
            operator: who is asking, for the record.
            timeout_s: until an answer must have come.
            ca: certificate to trust, as PEM: the service's own, if it was made there; else those of the system.
        """
        headers = [(b"Authorization", f"Bearer {token}".encode())]
        # As bytes: a name need not be ASCII.
        headers += [(b"Modallab-Operator", operator.encode())] if operator else []
        trusted = True if ca is None else ssl.create_default_context(cafile=ca)
        base = f"{url.rstrip('/')}/api/v1"
        self._http = httpx.Client(base_url=base, headers=headers, timeout=timeout_s, verify=trusted)

    def close(self) -> None:
        """Let go of the connection."""
        self._http.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _all(self, kind: type[Document], path: str, query: Mapping[str, str] | None = None) -> Iterator[Document]:
        asked, cursor = dict(query or {}), None
        while True:
            page = self._get(Page[kind], path, asked if cursor is None else asked | {"cursor": cursor})
            yield from page.items
            cursor = page.next
            if cursor is None:
                return

    def _get(self, kind: type[Document], path: str, query: Mapping[str, str] | None = None) -> Document:
        return kind.model_validate_json(self._send("GET", path, query=query).content)

    def _post(
        self, kind: type[Document], path: str, body: BaseModel | None = None, lease: RenewedLease | None = None
    ) -> Document:
        return kind.model_validate_json(self._send("POST", path, body, lease).content)

    def _put(
        self, kind: type[Document], path: str, body: BaseModel | None = None, lease: RenewedLease | None = None
    ) -> Document:
        return kind.model_validate_json(self._send("PUT", path, body, lease).content)

    def _delete(self, kind: type[Document], path: str) -> Document:
        return kind.model_validate_json(self._send("DELETE", path).content)

    def _send(
        self,
        method: str,
        path: str,
        body: BaseModel | None = None,
        lease: RenewedLease | None = None,
        query: Mapping[str, str] | None = None,
    ) -> httpx.Response:
        headers = {} if lease is None else {"Modallab-Lease": lease.id}
        if method == "POST":
            headers["Idempotency-Key"] = secrets.token_urlsafe(18)
        content = None if body is None else body.model_dump_json()
        if content is not None:
            headers["Content-Type"] = "application/json"
        for _ in range(TRIES - 1):
            try:
                return require_good(self._http.request(method, path, content=content, headers=headers, params=query))
            except _BROKEN:
                # Sent again it is not done again: it changes nothing, or says the same, or carries its key.
                time.sleep(AGAIN_S)
        return require_good(self._http.request(method, path, content=content, headers=headers, params=query))


class HeldLease:
    """The lease of a rig, as a context manager: renewed in the background, given back at the end."""

    def __init__(self, lease: Lease, renew: Callable[[Lease], object], release: Callable[[Lease], object]) -> None:
        self.lease = lease
        self._renew = renew
        self._release = release
        self._closing = Flag()
        self.lost: Exception | None = None
        self._thread = Thread(target=self._hold, name=f"lease of {lease.rig}", daemon=True)
        self._thread.start()

    @property
    def id(self) -> str:
        """What the service wants to see with every command."""
        return self.lease.id

    def close(self) -> None:
        """Give it back; a lease that is lost is not given back."""
        self._closing.set()
        self._thread.join()
        if self.lost is None:
            self._release(self.lease)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _hold(self) -> None:
        while not self._closing.wait(self.lease.ttl_s / 4):
            try:
                self._renew(self.lease)
            except httpx.HTTPError:
                # No answer is no rejection: a busy service may give one yet, before the lease is over.
                continue
            except Exception as error:
                # The next command says so too; a thread has nobody to notify.
                self.lost = error
                return
