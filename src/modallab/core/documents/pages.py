"""Lists that are read page by page, problems, and other envelopes."""

from typing import Any, Generic, TypeVar

from modallab.core.frozen import Frozen

Item = TypeVar("Item")


class Page(Frozen, Generic[Item]):
    """Part of a list; `next` is the cursor of the part after it, None at the end.

    Attributes:
        items: this part of the list.
        next: cursor of the part after it; None at the end.
    """

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
    """One line of the service's log of events; `seq` grows and never repeats.

    Attributes:
        seq: its number: grows by one, never used twice.
        utc: when, for people.
        rig: id of the rig it is about, else "".
        campaign: id of the campaign it is about, else "".
        run: name of the run it is about, else "".
        kind: what happened.
        content: the event itself, with its `kind` again.
    """

    seq: int
    utc: str
    rig: str
    campaign: str
    run: str
    kind: str
    content: dict[str, Any]


class AuditEntry(Frozen):
    """Who did what.

    Attributes:
        seq: its number: grows with every entry.
        utc: when, for people.
        operator: who did it.
        action: what was done.
        target: to what.
        detail: with what.
    """

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
    """Whether the service can work; `troubles` says what keeps it, `emergency_stop` where to `POST` in an emergency.

    Attributes:
        status: `good`, or `degraded` where `troubles` names what cannot be used.
        version: of the program.
        rigs: state of each rig's process, by its id.
        free_bytes: of the disk with the data folder.
        troubles: what cannot be used.
        emergency_stop: address to `POST` to in an emergency.
    """

    status: str
    version: str
    rigs: dict[str, str]
    free_bytes: int
    troubles: tuple[Trouble, ...] = ()
    emergency_stop: str = ""
