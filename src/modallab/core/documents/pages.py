"""Lists that are read page by page, problems, and other envelopes."""

from typing import Any, Generic, TypeVar

from modallab.core.frozen import Frozen

Item = TypeVar("Item")


class Page(Frozen, Generic[Item]):
    """One page of a list; `next` is the cursor of the next page, None at the end.

    Attributes:
        items: entries of this page.
        next: cursor of the next page; None at the end.
    """

    items: tuple[Item, ...]
    next: str | None = None


class ProblemDetails(Frozen):
    """Reason why a request was rejected (RFC 9457).

    Attributes:
        type: page of this kind of problem.
        title: kind of problem in words.
        status: HTTP status.
        code: kind of problem for programs.
        detail: fault with its value.
        remedy: what to do.
        where: field, file or device concerned.
        legal: allowed next states, for an illegal transition.
        errors: errors of each field, for an invalid document.
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
    """One event in the service's log.

    Attributes:
        seq: number of the event, which grows by one and is never reused.
        utc: date and time.
        rig: id of the rig concerned, otherwise "".
        campaign: id of the campaign concerned, otherwise "".
        run: name of the run concerned, otherwise "".
        kind: kind of event.
        content: the event, including its `kind`.
    """

    seq: int
    utc: str
    rig: str
    campaign: str
    run: str
    kind: str
    content: dict[str, Any]


class AuditEntry(Frozen):
    """An entry of the audit record.

    Attributes:
        seq: number of the entry, which grows by one.
        utc: date and time.
        operator: name of the operator.
        action: name of the action.
        target: object of the action.
        detail: further facts.
    """

    seq: int
    utc: str
    operator: str
    action: str
    target: str
    detail: dict[str, Any]


class ServiceFault(Frozen):
    """A part of the service that cannot be used.

    Attributes:
        part: `database`, or `rig ID`.
        what: description of the fault.
        since_utc: date and time of its detection.
        remedy: what to do.
    """

    part: str
    what: str
    since_utc: str
    remedy: str


class Health(Frozen):
    """State of the service.

    Attributes:
        status: `good`, or `degraded` with entries in `troubles`.
        version: version of the program.
        rigs: state of each rig's process, by id.
        free_bytes: free space on the disk of the data folder.
        troubles: parts that cannot be used.
        emergency_stop: address for a `POST` in an emergency.
    """

    status: str
    version: str
    rigs: dict[str, str]
    free_bytes: int
    troubles: tuple[ServiceFault, ...] = ()
    emergency_stop: str = ""
