"""Lists that are read page by page, problems, and other envelopes."""

from typing import Any, Generic, TypeVar

from modallab.core.frozen import Frozen

Item = TypeVar("Item")


class Page(Frozen, Generic[Item]):
    """Part of a list; `next` is the cursor of the part after it, None at the end."""

    items: tuple[Item, ...]
    next: str | None = None


class Problem(Frozen):
    """Why a request was not done (RFC 9457).

    Attributes:
        type: page that explains this kind of problem.
        title: the kind, in words.
        status: of HTTP.
        code: the kind, for programs.
        detail: what was wrong, with the value.
        remedy: what to do.
        where: the field, file or device concerned.
        legal: for a step that is not allowed now: what is.
        errors: for a document that is not valid: each field.
    """

    type: str
    title: str
    status: int
    code: str
    detail: str
    remedy: str = ""
    where: str = ""
    legal: tuple[str, ...] | None = None
    errors: tuple[dict[str, Any], ...] | None = None


class EventView(Frozen):
    """One line of the service's log of events; `seq` grows and never repeats."""

    seq: int
    utc: str
    rig: str
    campaign: str
    run: str
    kind: str
    content: dict[str, Any]


class AuditEntry(Frozen):
    """Who did what."""

    seq: int
    utc: str
    operator: str
    action: str
    target: str
    detail: dict[str, Any]


class Trouble(Frozen):
    """A part of the service that cannot be used.

    Attributes:
        part: `database`, or `rig ID`.
        what: is wrong.
        since_utc: when it was found so.
        remedy: what to do.
    """

    part: str
    what: str
    since_utc: str
    remedy: str


class Health(Frozen):
    """Whether the service can work; `troubles` says what keeps it, `emergency_stop` where to `POST` in an emergency."""

    status: str
    version: str
    rigs: dict[str, str]
    free_bytes: int
    troubles: tuple[Trouble, ...] = ()
    emergency_stop: str = ""
