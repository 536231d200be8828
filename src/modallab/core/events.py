"""What the acquisition process says while it works; a union distinguished by `kind`."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.core.frozen import Frozen

RunState = Literal[
    "created", "arming", "armed", "acquiring", "paused", "processing", "stopping", "done", "failed", "aborted"
]


class RunEvent(Frozen):
    """What is said of a run.

    Attributes:
        run: the run.
    """

    run: str


class StateChanged(RunEvent):
    """The run entered a state.

    Attributes:
        state: it is in now.
        reason: why it ended so, else "".
    """

    kind: Literal["state"] = "state"
    state: RunState
    reason: str = ""


class HitRequested(RunEvent):
    """Armed, the pre-trigger is full: strike this point now.

    Attributes:
        point: to strike.
        hit: its number there.
        of: how many there.
    """

    kind: Literal["hit_requested"] = "hit_requested"
    point: int
    hit: int
    of: int


class HitRejected(RunEvent):
    """A hit did not count; `reason` carries the number that decided.

    Attributes:
        point: that was to be struck.
        reason: with the number that decided.
    """

    kind: Literal["hit_rejected"] = "hit_rejected"
    point: int
    reason: str


class HitTooEarly(RunEvent):
    """Somebody struck before a hit was requested; rest is waited for again, and nothing was recorded.

    Attributes:
        point: that will be requested.
        peak_n: of the force.
    """

    kind: Literal["hit_too_early"] = "hit_too_early"
    point: int
    peak_n: float


class WaitingForRest(RunEvent):
    """The structure still moves before the next hit, said about once a block.

    Attributes:
        point: that will be struck.
        hit: its number there.
        of: how many there.
        residual_ratio: the motion as part of what the hit will make; None while that is not known.
        allowed: part that the plan allows.
        residual_hz: where it is largest.
        remaining_s: about how long still; None while that cannot be said.
    """

    kind: Literal["waiting_for_rest"] = "waiting_for_rest"
    point: int
    hit: int
    of: int
    residual_ratio: float | None
    allowed: float
    residual_hz: float
    remaining_s: float | None


class BlockAcknowledged(RunEvent):
    """A block is on the disk and in the table: from here on it cannot be lost.

    Attributes:
        n: its number in the run, from 0.
        name: unique in the run.
        first_sample: place of the first sample in the device's own count.
        count: samples per channel.
        crc32: of the samples as (channels, count), C order, little-endian.
        accepted: whether it counts.
        reason: why it does not.
        drive_point: point of the hit or of the shaker; None if unknown.
        level: of the drive, in a sine test.
        frequency_hz: of the drive, in a sine test.
        facts: what was measured when it was recorded: of a hit `peak_n`, `contact_s`, `second_ratio` (a double hit's
            share) and `drop_db` (how far the force spectrum falls within the band), of a sine `force_n`.
    """

    kind: Literal["block"] = "block"
    n: int
    name: str
    first_sample: int
    count: int
    crc32: int
    accepted: bool
    reason: str = ""
    drive_point: int | None = None
    level: str | None = None
    frequency_hz: float | None = None
    facts: dict[str, float | str] = Field(default_factory=dict[str, "float | str"])


class BlockDropped(RunEvent):
    """A block that was acknowledged no longer counts; its samples stay.

    Attributes:
        name: of the block.
        reason: why.
    """

    kind: Literal["dropped"] = "dropped"
    name: str
    reason: str


class BlockAccepted(RunEvent):
    """A block that was rejected counts all the same, by the operator's word.

    Attributes:
        name: of the block.
        reason: why.
    """

    kind: Literal["accepted"] = "accepted"
    name: str
    reason: str


class DecisionRequested(RunEvent):
    """The run waits for the operator: does this hit count? Accepting or dropping its block is the answer.

    Attributes:
        n: number of the block.
        name: of the block.
        point: that was to be struck.
        accepted: what the acceptance says.
        reason: why it says so, with the numbers that decided; "" where nothing speaks against it.
    """

    kind: Literal["decision_requested"] = "decision_requested"
    n: int
    name: str
    point: int
    accepted: bool
    reason: str = ""


class Notice(RunEvent):
    """What the operator should know before or while something moves, such as how long a burst may last.

    Attributes:
        what: in words.
    """

    kind: Literal["notice"] = "notice"
    what: str


class Progress(RunEvent):
    """How far the run is.

    Attributes:
        done: hits, frequencies or blocks so far.
        total: of how many.
        what: was done last, or is waited for.
    """

    kind: Literal["progress"] = "progress"
    done: int
    total: int
    what: str


class Failed(RunEvent):
    """The run ended early; blocks acknowledged before are kept.

    Attributes:
        code: of the error.
        what: was wrong.
        remedy: what to do.
    """

    kind: Literal["failed"] = "failed"
    code: str
    what: str
    remedy: str = ""


Event = Annotated[
    StateChanged
    | HitRequested
    | HitRejected
    | HitTooEarly
    | WaitingForRest
    | BlockAcknowledged
    | BlockDropped
    | BlockAccepted
    | DecisionRequested
    | Notice
    | Progress
    | Failed,
    Field(discriminator="kind"),
]
