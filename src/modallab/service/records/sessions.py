"""Sessions of browsers: a cookie stands for the token until its owner logs out, or it is too old."""

import hashlib
import secrets
from datetime import UTC, datetime, timedelta

from sqlalchemy import Engine, delete, insert, select

from modallab.storage.engine import reading, writing
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import SESSIONS

LIFE = timedelta(days=30)


class Sessions:
    """Those of one token: with another token they are void. The database holds no cookie, only a hash of it."""

    def __init__(self, engine: Engine, token: str) -> None:
        """Read those that were begun before.

        Raises:
            StorageError: they cannot be read.
        """
        self._engine = engine
        self._token = token
        oldest = (datetime.now(UTC) - LIFE).isoformat(timespec="milliseconds")
        with reading(engine) as connection:
            self._known = set(connection.scalars(select(SESSIONS.c.id).where(SESSIONS.c.created_utc >= oldest)))

    def begin(self) -> str:
        """A new session; returns its cookie.

        Raises:
            StorageError: it could not be kept.
        """
        cookie = secrets.token_urlsafe(32)
        oldest = (datetime.now(UTC) - LIFE).isoformat(timespec="milliseconds")
        with writing(self._engine) as connection:
            connection.execute(delete(SESSIONS).where(SESSIONS.c.created_utc < oldest))
            connection.execute(insert(SESSIONS).values(id=self._name(cookie), created_utc=utc_now()))
        self._known.add(self._name(cookie))
        return cookie

    def knows(self, cookie: str) -> bool:
        """Whether a cookie stands for the token."""
        return bool(cookie) and self._name(cookie) in self._known

    def end(self, cookie: str) -> None:
        """From now on the cookie stands for nothing.

        Raises:
            StorageError: it could not be kept; for this service it has ended all the same.
        """
        if not self.knows(cookie):
            return
        self._known.discard(self._name(cookie))
        with writing(self._engine) as connection:
            connection.execute(delete(SESSIONS).where(SESSIONS.c.id == self._name(cookie)))

    def _name(self, cookie: str) -> str:
        return hashlib.sha256(f"modallab session {self._token} {cookie}".encode()).hexdigest()
