"""The queue of runs of a rig: what is to be run next, what it waits for, and what its operator has consented to."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.core.frozen import Frozen, Truth
from modallab.core.plan import Plan

QueueState = Literal["waiting", "running", "done", "failed", "skipped"]
"""Of an item; the last three are for good."""


class QueueItemRequest(Frozen):
    """Request to queue a run.

    Attributes:
        campaign: id of the campaign, whose rig has the queue.
        plan: plan of the run, checked at once.
        note: remark for readers of the queue.
    """

    campaign: Annotated[str, Field(min_length=1, max_length=64)]
    plan: Plan
    note: Annotated[str, Field(max_length=400)] = ""


class QueueItem(Frozen):
    """A run in the queue.

    Attributes:
        id: id, made by the service.
        rig: id of the rig.
        campaign: id of the campaign.
        plan: plan of the run.
        drives: whether the run moves the output.
        state: waiting or running, or the outcome; `done` only if the run ended well.
        run: name of the run after its start; "" before.
        reason: reason of a failure or skip.
        note: remark for readers of the queue.
        operator: name of the operator.
        created_utc: date and time of queueing.
        estimated_s: estimated duration; an impact test with 15 s for each hit.
    """

    id: str
    rig: str
    campaign: str
    plan: Plan
    drives: bool
    state: QueueState
    run: str
    reason: str
    note: str
    operator: str
    created_utc: str
    estimated_s: float


class ConsentRequest(Frozen):
    """Permission of the lease's holder to start queued runs automatically.

    The permission ends with the lease, an emergency stop, a failed or stopped run, or a run started by hand.
    It also ends with a restart of the rig's process or of the service.

    Attributes:
        drive: permit tests that move the output: the bench has been checked.
        at_bench: permit impact tests: the operator stands there with the hammer.
        items: items of the queue that it covers (default: those waiting now); later items need another consent.
        for_s: duration of the consent.
    """

    drive: Truth = False
    at_bench: Truth = False
    items: Annotated[tuple[Annotated[str, Field(max_length=64)], ...], Field(max_length=200)] | None = None
    for_s: Annotated[float, Field(gt=0, le=86400)] = 28800.0


class ConsentView(Frozen):
    """A consent in force.

    Attributes:
        operator: name of the operator.
        drive: whether tests that move the output may start.
        at_bench: whether impact tests may start.
        items: items of the queue that it covers.
        remaining_s: remaining time, if nothing ends it.
    """

    operator: str
    drive: bool
    at_bench: bool
    items: tuple[str, ...]
    remaining_s: float


class QueueView(Frozen):
    """The queue of a rig.

    Attributes:
        rig: id of the rig.
        paused: whether no run starts until somebody resumes the queue.
        reason: reason for the pause.
        waits_for: what the next item waits for; "" if nothing.
        consent: consent in force; None: none.
        remaining_s: estimated time of all active and waiting items.
        items: active and waiting items in order; then ended ones, the newest first, on request.
    """

    rig: str
    paused: bool
    reason: str
    waits_for: str
    consent: ConsentView | None
    remaining_s: float
    items: tuple[QueueItem, ...]


class QueueOrder(Frozen):
    """Order of the waiting items.

    Attributes:
        items: all waiting items, the next one first.
    """

    items: Annotated[tuple[Annotated[str, Field(max_length=64)], ...], Field(max_length=200)]


class QueueReason(Frozen):
    """Reason for a paused queue or a skipped item.

    Attributes:
        reason: reason in words, for the record.
    """

    reason: Annotated[str, Field(max_length=400)] = ""
