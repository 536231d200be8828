"""Users and their tokens, in the service's database."""

import hashlib
import logging
import secrets
from datetime import UTC, datetime, timedelta
from threading import Event as Flag
from threading import Thread
from typing import Any

from sqlalchemy import Connection, Engine, insert, select, update

from modallab.core.documents.users import (
    RANK,
    CallerView,
    NewToken,
    Role,
    TokenRequest,
    TokenView,
    UserRequest,
    UserView,
)
from modallab.core.errors import StorageError
from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.records import audit
from modallab.storage.engine import read_transaction, write_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.service_tables import TOKENS, USERS


class UserTable:
    """Users and tokens. A name is used once: the record of who did what must not speak of two people."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def add(self, new: UserRequest, by: str) -> UserView:
        """Add a user.

        Raises:
            ConflictError: the name was used before.
            StorageError: it could not be kept.
        """
        user = UserView(name=new.name, role=new.role, created_utc=utc_now())
        with write_transaction(self._engine) as connection:
            if _user_row(connection, new.name) is not None:
                raise ConflictError(f"there is a user {new.name!r} already", where="name", remedy="choose another name")
            connection.execute(insert(USERS).values(user.model_dump()))
            audit.add_audit_note(connection, by, "add-user", new.name, {"role": new.role})
        return user

    def all_users(self) -> list[UserView]:
        """All users by name, including revoked ones."""
        with read_transaction(self._engine) as connection:
            rows = connection.execute(select(USERS).order_by(USERS.c.name)).mappings()
            return [UserView.model_validate(dict(row)) for row in rows]

    def get(self, name: str) -> UserView:
        """One user.

        Raises:
            NotFoundError: there is none of this name.
        """
        with read_transaction(self._engine) as connection:
            return _user(connection, name)

    def change(self, name: str, role: Role, by: str) -> UserView:
        """Give a user another role.

        Raises:
            NotFoundError: there is none of this name.
            ConflictError: the user was revoked.
        """
        with write_transaction(self._engine) as connection:
            _require_active(_user(connection, name))
            connection.execute(update(USERS).where(USERS.c.name == name).values(role=role))
            audit.add_audit_note(connection, by, "change-user", name, {"role": role})
            return _user(connection, name)

    def revoke(self, name: str, by: str) -> UserView:
        """From now on no token of a user counts; the name stays in the record of what was done.

        Raises:
            NotFoundError: there is none of this name.
        """
        with write_transaction(self._engine) as connection:
            if not _user(connection, name).revoked_utc:
                connection.execute(update(USERS).where(USERS.c.name == name).values(revoked_utc=utc_now()))
                audit.add_audit_note(connection, by, "revoke-user", name, {})
            return _user(connection, name)

    def make_token(self, name: str, new: TokenRequest, by: str) -> NewToken:
        """Make a token for a user; only a hash of it is kept.

        Raises:
            NotFoundError: there is no user of this name.
            ConflictError: the user was revoked, or may not do what the token is for.
        """
        ident = secrets.token_hex(6)
        token = f"{ident}.{secrets.token_urlsafe(32)}"
        until = "" if new.ttl_days is None else _time_after(new.ttl_days)
        row: dict[str, Any] = new.model_dump(exclude={"ttl_days"}) | {"rigs": list(new.rigs)}
        row |= {"id": ident, "user": name, "digest": digest_of(token), "created_utc": utc_now(), "expires_utc": until}
        with write_transaction(self._engine) as connection:
            user = _user(connection, name)
            _require_active(user)
            if new.role is not None and RANK[new.role] > RANK[user.role]:
                raise ConflictError(f"{name} is {user.role}, not {new.role}", where="role", remedy="ask for less")
            connection.execute(insert(TOKENS).values(row))
            audit.add_audit_note(
                connection, by, "make-token", name, {"token": ident, "label": new.label, "expires": until}
            )
            return NewToken(token=token, about=_token(connection, name, ident))

    def tokens(self, name: str) -> list[TokenView]:
        """The tokens of a user, the oldest first, including revoked and expired ones.

        Raises:
            NotFoundError: there is no user of this name.
        """
        query = select(TOKENS).where(TOKENS.c.user == name).order_by(TOKENS.c.created_utc, TOKENS.c.id)
        with read_transaction(self._engine) as connection:
            user = _user(connection, name)
            return [_user_view(row, user.role) for row in connection.execute(query).mappings()]

    def revoke_token(self, name: str, ident: str, by: str) -> TokenView:
        """From now on a token does not count.

        Raises:
            NotFoundError: the user has no such token.
        """
        with write_transaction(self._engine) as connection:
            if not _token(connection, name, ident).revoked_utc:
                connection.execute(update(TOKENS).where(TOKENS.c.id == ident).values(revoked_utc=utc_now()))
                audit.add_audit_note(connection, by, "revoke-token", name, {"token": ident})
            return _token(connection, name, ident)

    def token_digests(self) -> dict[str, tuple[str, TokenView]]:
        """Every token that was not revoked, nor its user: id -> its digest, and what may be done with it.

        Raises:
            StorageError: they cannot be read.
        """
        query = select(TOKENS, USERS.c.role.label("most")).join(USERS, USERS.c.name == TOKENS.c.user)
        query = query.where(TOKENS.c.revoked_utc == "", USERS.c.revoked_utc == "")
        with read_transaction(self._engine) as connection:
            return {
                row["id"]: (row["digest"], _user_view(row, row["most"])) for row in connection.execute(query).mappings()
            }


def digest_of(token: str) -> str:
    """What is kept of a token: it is random and long, so that a plain SHA-256 gives nothing away."""
    return hashlib.sha256(token.encode()).hexdigest()


def _time_after(days: float) -> str:
    return (datetime.now(UTC) + timedelta(days=days)).isoformat(timespec="milliseconds")


def _user_row(connection: Connection, name: str) -> Any:
    return connection.execute(select(USERS).where(USERS.c.name == name)).mappings().one_or_none()


def _user(connection: Connection, name: str) -> UserView:
    row = _user_row(connection, name)
    if row is None:
        raise NotFoundError(f"there is no user {name!r}", remedy="look at the list of users")
    return UserView.model_validate(dict(row))


def _require_active(user: UserView) -> None:
    if user.revoked_utc:
        raise ConflictError(f"{user.name} was revoked", where=user.name, remedy="add a user of another name")


def _token(connection: Connection, name: str, ident: str) -> TokenView:
    query = select(TOKENS).where(TOKENS.c.id == ident, TOKENS.c.user == name)
    row = connection.execute(query).mappings().one_or_none()
    if row is None:
        raise NotFoundError(f"{name} has no token {ident!r}", remedy="look at the list of the user's tokens")
    return _user_view(row, _user(connection, name).role)


def _user_view(row: Any, most: Role) -> TokenView:
    role: Role = row["role"] if row["role"] is not None and RANK[row["role"]] < RANK[most] else most
    known = {name: row[name] for name in TokenView.model_fields if name not in ("role", "rigs")}
    return TokenView(**known, role=role, rigs=tuple(row["rigs"]))


LOG = logging.getLogger(__name__)
UNKNOWN = "unknown"
"""Who asks without a name, by the service's own token."""
LOOK_S = 1.0
"""Another process may revoke a token: for so long it may count yet."""


OWN = CallerView(name="", role="admin", rigs=(), token="", expires_utc="")
"""Whoever has the service's own token."""


class ValidTokens:
    """Tokens that count now: the service's own, and those of its users."""

    def __init__(self, engine: Engine, token: str) -> None:
        """Read them.

        Raises:
            StorageError: they cannot be read.
        """
        self._users = UserTable(engine)
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
        self._known = self._users.token_digests()

    def of_token(self, sent: str) -> CallerView | None:
        """Whose a token is; None if it counts for nothing."""
        if secrets.compare_digest(sent.encode(), self._own.encode()):
            return OWN
        ident, _, _ = sent.partition(".")
        known = self._known.get(ident)
        if known is None or not secrets.compare_digest(known[0], digest_of(sent)):
            return None
        return self.of_id(ident)

    def of_id(self, ident: str) -> CallerView | None:
        """Whose the token of an id is, "" for the service's own; None if it counts for nothing."""
        if ident == "":
            return OWN
        known = self._known.get(ident)
        if known is None or (known[1].expires_utc and known[1].expires_utc <= utc_now()):
            return None
        view = known[1]
        return CallerView(name=view.user, role=view.role, rigs=view.rigs, token=ident, expires_utc=view.expires_utc)

    def cookie_key(self, ident: str) -> str:
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
