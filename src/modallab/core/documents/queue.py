"""The queue of runs of a rig: what is to be run next, what it waits for, and what its operator has consented to."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.core.frozen import Frozen, Truth
from modallab.core.plan import Plan

QueueState = Literal["waiting", "running", "done", "failed", "skipped"]
"""Of an item; the last three are for good."""


class QueueItemNew(Frozen):
    """A run to be queued.

    Attributes:
        campaign: it will belong to; the campaign's rig is the queue's.
        plan: what to do, looked at now as if it began now.
        note: for whoever reads the queue.
    """

    campaign: Annotated[str, Field(min_length=1, max_length=64)]
    plan: Plan
    note: Annotated[str, Field(max_length=400)] = ""


class QueueItem(Frozen):
    """A run in the queue.

    Attributes:
        id: made by the service.
        rig: whose queue it is in.
        campaign: the run will belong to.
        plan: what to do.
        drives: whether the run moves the output.
        state: waiting or running, or how it ended; `done` only if the run ended well.
        run: the run's name, once it has begun; "" before.
        reason: why it failed or was skipped.
        note: for whoever reads the queue.
        operator: who queued it.
        created_utc: when it was queued.
        estimated_s: about how long it takes, of an impact test with 15 s a hit.
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


class ConsentNew(Frozen):
    """What may begin by itself, by the word of who holds the lease.

    It ends with the lease, an emergency stop, a run that does not end well, one begun by hand, or a new start of the
    rig's process or of the service.

    Attributes:
        drive: tests that move the output may begin: I have looked at the bench.
        at_bench: impact tests may begin: I stand there with the hammer.
        items: of the queue it is for; none: those that wait now. Whatever is queued later needs another consent.
        for_s: for so long.
    """

    drive: Truth = False
    at_bench: Truth = False
    items: Annotated[tuple[Annotated[str, Field(max_length=64)], ...], Field(max_length=200)] | None = None
    for_s: Annotated[float, Field(gt=0, le=86400)] = 28800.0


class ConsentView(Frozen):
    """A consent that counts now.

    Attributes:
        operator: who gave it.
        drive: tests that move the output may begin.
        at_bench: impact tests may begin.
        items: of the queue it is for.
        remaining_s: for so long, if nothing ends it.
    """

    operator: str
    drive: bool
    at_bench: bool
    items: tuple[str, ...]
    remaining_s: float


class QueueView(Frozen):
    """The queue of a rig.

    Attributes:
        rig: its id.
        paused: whether nothing begins until somebody resumes it.
        reason: why it is paused.
        waits_for: what keeps the next item from beginning; "" if nothing does, or nothing waits.
        consent: what may begin by itself; None: nothing.
        remaining_s: about how long what waits and goes on takes.
        items: what goes on, then what waits, in order; ended ones, the newest first, where they were asked for.
    """

    rig: str
    paused: bool
    reason: str
    waits_for: str
    consent: ConsentView | None
    remaining_s: float
    items: tuple[QueueItem, ...]


class QueueOrder(Frozen):
    """The order in which items are run.

    Attributes:
        items: all that wait, the next one first.
    """

    items: Annotated[tuple[Annotated[str, Field(max_length=64)], ...], Field(max_length=200)]


class QueueReason(Frozen):
    """Why a queue is paused or an item skipped.

    Attributes:
        reason: in words, for the record.
    """

    reason: Annotated[str, Field(max_length=400)] = ""
