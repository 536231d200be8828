"""Sessions of browsers: a cookie stands for a token until its owner logs out or it is too old; and links to log in."""

import hashlib
import secrets
from collections.abc import Callable
from datetime import UTC, datetime, timedelta

from sqlalchemy import Engine, delete, insert, select

from modallab.storage.engine import read_transaction, write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import SESSIONS

LIFE = timedelta(days=30)
LINK_LIFE = timedelta(minutes=10)


class BrowserSessions:
    """Browsers that are logged in, and links that log one in; void once their token is. Only hashes are kept."""

    def __init__(self, engine: Engine, secret: Callable[[str], str]) -> None:
        """Read the sessions that were begun before.

        Args:
            engine: the database.
            secret: of the token of an id, "" for the service's own; "" if that counts for nothing any more.

        Raises:
            StorageError: they cannot be read.
        """
        self._engine = engine
        self._secret = secret
        with read_transaction(engine) as connection:
            rows = connection.execute(select(SESSIONS).where(SESSIONS.c.created_utc >= _time_before(LIFE)))
            self._known = {row.id: row.created_utc for row in rows}

    def begin(self, token: str) -> str:
        """A new session for the token of this id; returns its cookie.

        Raises:
            StorageError: it could not be kept.
        """
        cookie = _random_cookie(token)
        with write_transaction(self._engine) as connection:
            connection.execute(delete(SESSIONS).where(SESSIONS.c.created_utc < _time_before(LIFE)))
            connection.execute(insert(SESSIONS).values(id=self._name(cookie), created_utc=utc_now()))
        self._known[self._name(cookie)] = utc_now()
        return cookie

    def token_of(self, cookie: str) -> str | None:
        """Id of the token that a cookie stands for, "" for the service's own; None if it stands for nothing."""
        token = _token_of(cookie)
        if not cookie or not self._secret(token):
            return None
        return token if self._known.get(self._name(cookie), "") >= _time_before(LIFE) else None

    def end(self, cookie: str) -> None:
        """From now on the cookie stands for nothing.

        Raises:
            StorageError: it could not be kept; for this service it has ended all the same.
        """
        if self.token_of(cookie) is None:
            return
        self._known.pop(self._name(cookie), None)
        with write_transaction(self._engine) as connection:
            connection.execute(delete(SESSIONS).where(SESSIONS.c.id == self._name(cookie)))

    def use_link(self, key: str) -> str | None:
        """Id of the token that a link logs in with; None if it was used, is too old, or never was one.

        Raises:
            StorageError: that it was used could not be kept, and so it was not.
        """
        token = _token_of(key)
        secret = self._secret(token)
        if not secret:
            return None
        mine = (
            SESSIONS.c.id == _hash_with_secret("link", secret, key),
            SESSIONS.c.created_utc >= _time_before(LINK_LIFE),
        )
        with read_transaction(self._engine) as connection:
            # Anyone may try, and nobody has the database written by that.
            if connection.scalar(select(SESSIONS.c.id).where(*mine)) is None:
                return None
        with write_transaction(self._engine) as connection:
            return token if connection.execute(delete(SESSIONS).where(*mine)).rowcount == 1 else None

    def _name(self, cookie: str) -> str:
        return _hash_with_secret("session", self._secret(_token_of(cookie)), cookie)


def make_link(engine: Engine, token: str, secret: str) -> tuple[str, str]:
    """A path that logs a browser in once, and until when; with the token of an id ("" for the service's own).

    Raises:
        StorageError: it could not be kept.
    """
    key = _random_cookie(token)
    with write_transaction(engine) as connection:
        connection.execute(insert(SESSIONS).values(id=_hash_with_secret("link", secret, key), created_utc=utc_now()))
    until = datetime.now(UTC) + LINK_LIFE
    return f"/login?key={key}", until.isoformat(timespec="milliseconds")


def _random_cookie(token: str) -> str:
    return f"{token}.{secrets.token_urlsafe(32)}" if token else secrets.token_urlsafe(32)


def _token_of(text: str) -> str:
    token, dot, _ = text.partition(".")
    return token if dot else ""


def _hash_with_secret(what: str, secret: str, text: str) -> str:
    return hashlib.sha256(f"modallab {what} {secret} {text}".encode()).hexdigest()


def _time_before(life: timedelta) -> str:
    return (datetime.now(UTC) - life).isoformat(timespec="milliseconds")
