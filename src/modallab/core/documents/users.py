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


class UserNew(Frozen):
    """A new user.

    Attributes:
        name: as it will stand in the record of who did what; it is never used again for somebody else.
        role: what the user may do.
    """

    name: UserName
    role: Role = "operator"


class UserChange(Frozen):
    """What may be changed of a user.

    Attributes:
        role: what the user may do from now on; a token may do less, and never more.
    """

    role: Role


class UserView(Frozen):
    """A user.

    Attributes:
        name: as it stands in the record of who did what.
        role: what the user may do.
        created_utc: when the user was added.
        revoked_utc: since when none of the user's tokens counts any more; "" while they do.
    """

    name: str
    role: Role
    created_utc: str
    revoked_utc: str = ""


class TokenNew(Frozen):
    """A new token of a user.

    Attributes:
        label: where it is kept, such as the name of a program.
        role: what may be done with it, if less than the user may.
        rigs: the only rigs that may be worked at with it; none: all of them. Everything may be looked at.
        ttl_days: for so long it counts; none: until it is revoked.
    """

    label: Annotated[str, Field(max_length=120, pattern=r"^[^\x00-\x1f\x7f]*$")] = ""
    role: Role | None = None
    rigs: RigIds = ()
    ttl_days: TtlDays | None = None


class TokenView(Frozen):
    """A token, without what is secret about it.

    Attributes:
        id: its name.
        user: whose it is.
        label: where it is kept.
        role: what may be done with it: at most what its user may.
        rigs: the only rigs that may be worked at with it; none: all of them.
        created_utc: when it was made.
        expires_utc: until when it counts; "" for until it is revoked.
        revoked_utc: since when it does not count any more; "" while it does.
    """

    id: str
    user: str
    label: str
    role: Role
    rigs: tuple[str, ...]
    created_utc: str
    expires_utc: str = ""
    revoked_utc: str = ""


class TokenMade(Frozen):
    """A token that was just made.

    Attributes:
        token: to be sent as `Authorization: Bearer TOKEN`. It is shown this once and kept nowhere.
        about: the same as in the list of tokens.
    """

    token: str
    about: TokenView


class CallerView(Frozen):
    """Who is asking, by the token or the cookie that was sent.

    Attributes:
        name: of the user; "" for the service's own token, whose holder says who he is.
        role: what may be done.
        rigs: the only rigs that may be worked at; none: all of them.
        token: id of the token; "" for the service's own.
        expires_utc: until when it counts; "" for until it is revoked.
    """

    name: str
    role: Role
    rigs: tuple[str, ...]
    token: str
    expires_utc: str


class LoginLink(Frozen):
    """An address that logs a browser in, once.

    Attributes:
        path: on this service; open it in a browser.
        expires_utc: until when it can be opened.
    """

    path: str
    expires_utc: str
