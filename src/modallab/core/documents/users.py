"""Users of the service: who may do what, and the tokens they carry."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.core.frozen import Frozen

Role = Literal["observer", "operator", "admin"]
"""What somebody may do: look, work at the rigs, or also say who else may. Each may what the one before may."""

RANK: dict[Role, int] = {"observer": 0, "operator": 1, "admin": 2}

UserName = Annotated[str, Field(min_length=1, max_length=80, pattern=r"^[^\x00-\x1f\x7f/]+$")]
RigIds = Annotated[tuple[Annotated[str, Field(min_length=1, max_length=64)], ...], Field(max_length=100)]
TtlDays = Annotated[float, Field(gt=0, le=3660)]


class UserRequest(Frozen):
    """A new user.

    Attributes:
        name: name in the audit record, never given to another person again.
        role: role of the user.
    """

    name: UserName
    role: Role = "operator"


class UserChange(Frozen):
    """Change of a user.

    Attributes:
        role: role of the user from now on; a token never has more rights.
    """

    role: Role


class UserView(Frozen):
    """A user.

    Attributes:
        name: name in the audit record.
        role: role of the user.
        created_utc: date and time of creation.
        revoked_utc: date and time of revocation; "" while valid.
    """

    name: str
    role: Role
    created_utc: str
    revoked_utc: str = ""


class TokenRequest(Frozen):
    """Request for a new token of a user.

    Attributes:
        label: name of the program or device that uses the token.
        role: role of the token, if lower than the user's.
        rigs: rigs that the token is limited to; empty: all. Reading is not limited.
        ttl_days: days of validity; null: until it is revoked.
    """

    label: Annotated[str, Field(max_length=120, pattern=r"^[^\x00-\x1f\x7f]*$")] = ""
    role: Role | None = None
    rigs: RigIds = ()
    ttl_days: TtlDays | None = None


class TokenView(Frozen):
    """A token without its secret.

    Attributes:
        id: its name.
        user: name of the user.
        label: name of the program or device that uses the token.
        role: role of the token, at most that of its user.
        rigs: rigs that the token is limited to; empty: all.
        created_utc: date and time of its creation.
        expires_utc: end of validity; "" for until it is revoked.
        revoked_utc: date and time of its revocation; "" while valid.
    """

    id: str
    user: str
    label: str
    role: Role
    rigs: tuple[str, ...]
    created_utc: str
    expires_utc: str = ""
    revoked_utc: str = ""


class NewToken(Frozen):
    """A new token.

    Attributes:
        token: value for `Authorization: Bearer TOKEN`. It is shown only once and stored nowhere.
        about: entry in the list of tokens.
    """

    token: str
    about: TokenView


class CallerView(Frozen):
    """The user of a request, by token or cookie.

    Attributes:
        name: name of the user; "" for the service's own token.
        role: role of the user.
        rigs: rigs that the token is limited to; empty: all rigs.
        token: id of the token; "" for the service's own.
        expires_utc: end of validity; "" for until it is revoked.
    """

    name: str
    role: Role
    rigs: tuple[str, ...]
    token: str
    expires_utc: str


class LoginLink(Frozen):
    """An address that logs a browser in, once.

    Attributes:
        path: path on this service, to open in a browser.
        expires_utc: end of validity.
    """

    path: str
    expires_utc: str
