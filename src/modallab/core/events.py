"""What the acquisition process says while it works; a union distinguished by `kind`."""

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from modallab.core.frozen import Frozen

RunState = Literal[
    "created", "arming", "armed", "acquiring", "paused", "processing", "stopping", "done", "failed", "aborted"
]


class StateChanged(Frozen):
    """The run entered a state."""

    kind: Literal["state"] = "state"
    run: str
    state: RunState
    reason: str = ""


class HitRequested(Frozen):
    """Armed, the pre-trigger is full: strike this point now."""

    kind: Literal["hit_requested"] = "hit_requested"
    run: str
    point: int
    hit: int
    of: int


class HitRejected(Frozen):
    """A hit did not count; `reason` carries the number that decided."""

    kind: Literal["hit_rejected"] = "hit_rejected"
    run: str
    point: int
    reason: str


class BlockAcknowledged(Frozen):
    """A block is on the disk and in the table: from here on it cannot be lost."""

    kind: Literal["block"] = "block"
    run: str
    n: int
    name: str
    first_sample: int
    count: int
    crc32: int
    accepted: bool
    reason: str = ""


class BlockDropped(Frozen):
    """A block that was acknowledged no longer counts; its samples stay."""

    kind: Literal["dropped"] = "dropped"
    run: str
    name: str
    reason: str


class Notice(Frozen):
    """What the operator should know before or while something moves, such as how long a burst may last."""

    kind: Literal["notice"] = "notice"
    run: str
    what: str


class Progress(Frozen):
    """How far the run is."""

    kind: Literal["progress"] = "progress"
    run: str
    done: int
    total: int
    what: str


class Failed(Frozen):
    """The run ended early; blocks acknowledged before are kept."""

    kind: Literal["failed"] = "failed"
    run: str
    code: str
    what: str
    remedy: str = ""


Event = Annotated[
    StateChanged | HitRequested | HitRejected | BlockAcknowledged | BlockDropped | Notice | Progress | Failed,
    Field(discriminator="kind"),
]
EVENT: TypeAdapter[Event] = TypeAdapter(Event)
