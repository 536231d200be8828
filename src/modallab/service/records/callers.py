"""Who stands behind a token: looked up in memory, so that it is known also while the database is away."""

import logging
import secrets
from dataclasses import dataclass
from threading import Event as Flag
from threading import Thread

from sqlalchemy import Engine

from modallab.core.documents.users import CallerView, Role, TokenView
from modallab.core.errors import StorageError
from modallab.service.records.users import Users, digest_of
from modallab.storage.recorder import utc_now

LOG = logging.getLogger(__name__)
UNKNOWN = "unknown"
"""Who asks without a name, by the service's own token."""
LOOK_S = 1.0
"""Another process may revoke a token: for so long it may count yet."""


@dataclass(frozen=True, slots=True)
class Caller:
    """Who asks.

    Attributes:
        name: of the user; "" for the service's own token, whose holder says who he is.
        role: what may be done.
        rigs: the only rigs that may be worked at; none: all.
        token: id of the token; "" for the service's own.
        expires_utc: until when it counts; "" for ever.
    """

    name: str
    role: Role
    rigs: tuple[str, ...] = ()
    token: str = ""
    expires_utc: str = ""

    @property
    def view(self) -> CallerView:
        """For whoever asks who he is."""
        return CallerView(
            name=self.name, role=self.role, rigs=self.rigs, token=self.token, expires_utc=self.expires_utc
        )


OWN = Caller("", "admin")
"""Whoever has the service's own token."""


class Callers:
    """Tokens that count now: the service's own, and those of its users."""

    def __init__(self, engine: Engine, token: str) -> None:
        """Read them.

        Raises:
            StorageError: they cannot be read.
        """
        self._users = Users(engine)
        self._own = token
        self._known: dict[str, tuple[str, TokenView]] = {}
        self._closing = Flag()
        self.refresh()

    def open(self) -> None:
        """Read them again now and then, until `close`."""
        Thread(target=self._keep_up, name="tokens", daemon=True).start()

    def close(self) -> None:
        """Read them no more."""
        self._closing.set()

    def refresh(self) -> None:
        """Read them again.

        Raises:
            StorageError: they cannot be read; those that were known still are.
        """
        self._known = self._users.digests()

    def of_token(self, sent: str) -> Caller | None:
        """Whose a token is; None if it counts for nothing."""
        if secrets.compare_digest(sent.encode(), self._own.encode()):
            return OWN
        ident, _, _ = sent.partition(".")
        known = self._known.get(ident)
        if known is None or not secrets.compare_digest(known[0], digest_of(sent)):
            return None
        return self.of_id(ident)

    def of_id(self, ident: str) -> Caller | None:
        """Whose the token of an id is, "" for the service's own; None if it counts for nothing."""
        if ident == "":
            return OWN
        known = self._known.get(ident)
        if known is None or (known[1].expires_utc and known[1].expires_utc <= utc_now()):
            return None
        view = known[1]
        return Caller(view.user, view.role, view.rigs, ident, view.expires_utc)

    def secret(self, ident: str) -> str:
        """What cookies of a token are hashed with: with another token they are void; "" if it counts for nothing."""
        if ident == "":
            return self._own
        return "" if self.of_id(ident) is None else self._known[ident][0]

    def _keep_up(self) -> None:
        while not self._closing.wait(LOOK_S):
            try:
                self.refresh()
            except StorageError as error:
                LOG.debug("tokens: %s", error)
