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
        run: name of the run.
    """

    run: str


class StateChanged(RunEvent):
    """The state of the run has changed.

    Attributes:
        state: present state.
        reason: reason of the end, otherwise "".
    """

    kind: Literal["state"] = "state"
    state: RunState
    reason: str = ""


class HitRequested(RunEvent):
    """The trigger is armed: strike this point now.

    Attributes:
        point: point to hit.
        hit: number of the hit at this point.
        of: number of hits at this point.
    """

    kind: Literal["hit_requested"] = "hit_requested"
    point: int
    hit: int
    of: int


class HitRejected(RunEvent):
    """A hit was rejected; `reason` has the value and the limit.

    Attributes:
        point: requested point.
        reason: reason with value and limit.
    """

    kind: Literal["hit_rejected"] = "hit_rejected"
    point: int
    reason: str


class HitTooEarly(RunEvent):
    """A hit came before the request; nothing was recorded, and the run waits for rest again.

    Attributes:
        point: point of the next request.
        peak_n: peak of the force.
    """

    kind: Literal["hit_too_early"] = "hit_too_early"
    point: int
    peak_n: float


class WaitingForRest(RunEvent):
    """The structure still moves before the next hit; sent about once a block.

    Attributes:
        point: next point.
        hit: number of the hit at this point.
        of: number of hits at this point.
        residual_ratio: motion relative to that of the expected hit; None if unknown.
        allowed: largest motion that the plan allows.
        residual_hz: frequency of the largest motion.
        remaining_s: expected remaining time; None if unknown.
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
    """A block is on the disk and in the table, and can no longer be lost.

    Attributes:
        n: number of the block in the run, from 0.
        name: name, unique in the run.
        first_sample: index of the first sample in the device's own count.
        count: samples per channel.
        crc32: checksum of the samples as (channels, count), C order, little-endian.
        accepted: whether the block is valid.
        reason: reason of a rejection.
        drive_point: point of the hit or of the shaker; None if unknown.
        level: level of the drive, in a sine test.
        frequency_hz: of the drive, in a sine test.
        facts: measured values: of a hit `peak_n`, `contact_s`, `second_ratio` (second pulse over the first) and
            `drop_db` (drop of the force spectrum within the band), of a sine `force_n`.
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
    """An acknowledged block is no longer valid; its samples stay.

    Attributes:
        name: name of the block.
        reason: reason.
    """

    kind: Literal["dropped"] = "dropped"
    name: str
    reason: str


class BlockAccepted(RunEvent):
    """The operator has accepted a rejected block.

    Attributes:
        name: name of the block.
        reason: reason.
    """

    kind: Literal["accepted"] = "accepted"
    name: str
    reason: str


class DecisionRequested(RunEvent):
    """The run waits for the operator's decision on a hit: accept or drop its block.

    Attributes:
        n: number of the block.
        name: name of the block.
        point: requested point.
        accepted: verdict of the acceptance limits.
        reason: reason of the verdict, with values and limits; "" if none.
    """

    kind: Literal["decision_requested"] = "decision_requested"
    n: int
    name: str
    point: int
    accepted: bool
    reason: str = ""


class OperatorNotice(RunEvent):
    """A fact for the operator before or during motion, such as the duration of the longest burst.

    Attributes:
        what: notice in words.
    """

    kind: Literal["notice"] = "notice"
    what: str


class RunProgress(RunEvent):
    """Progress of the run.

    Attributes:
        done: number of hits, frequencies or blocks so far.
        total: total number.
        what: last or expected step.
    """

    kind: Literal["progress"] = "progress"
    done: int
    total: int
    what: str


class RunFailed(RunEvent):
    """The run ended early; blocks acknowledged before are kept.

    Attributes:
        code: code of the error.
        what: fault in words.
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
    | OperatorNotice
    | RunProgress
    | RunFailed,
    Field(discriminator="kind"),
]
