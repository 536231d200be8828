"""Campaigns, their runs and blocks, and what an operator may ask of a run."""

from typing import Annotated, Literal

from pydantic import Field, PositiveFloat

from modallab.core.events import RunState
from modallab.core.frozen import Frozen, RealArray, Truth
from modallab.core.plan import Plan
from modallab.core.units import Test

Name = Annotated[str, Field(min_length=1, max_length=120, pattern=r"^[^\x00-\x1f\x7f]+$")]
Note = Annotated[str, Field(max_length=4000)]


class CampaignNew(Frozen):
    """A new campaign on a rig of this service.

    Attributes:
        name: for people; need not be unique.
        rig: id of the rig.
        note: for people.
    """

    name: Name
    rig: Annotated[str, Field(min_length=1, max_length=64)]
    note: Note = ""


class CampaignChange(Frozen):
    """What may be changed afterwards; what is left out stays.

    Attributes:
        name: the new one; None: as it was.
        note: the new one; None: as it was.
    """

    name: Name | None = None
    note: Note | None = None


class CampaignView(Frozen):
    """A campaign.

    Attributes:
        id: made by the service.
        name: for people.
        note: for people.
        rig: id of the rig it is on.
        operator: who made it.
        created_utc: when.
        revision: its ETag; grows with every change.
        runs: names of its runs, the oldest first, without those that are archived or deleted.
        archived_utc: when it was archived; "" if it is not.
        deleted_utc: when it was deleted; "" if it is not.
        purge_utc: until when it can be restored; from then on its samples are deleted.
    """

    id: str
    name: str
    note: str
    rig: str
    operator: str
    created_utc: str
    revision: int
    runs: tuple[str, ...] = ()
    archived_utc: str = ""
    deleted_utc: str = ""
    purge_utc: str = ""


Action = Literal["pause", "resume", "repeat", "drop", "accept", "stop", "abort"]


class RunNew(Frozen):
    """Begin a run; `continues` names an ended run of the same campaign whose good blocks it takes over.

    Without a plan, a run that continues another does what is left of that one's plan.

    Attributes:
        plan: what to do; None: what is left of the plan of the run it continues.
        continues: an ended run of the same campaign, whose good blocks this one takes over; None: it begins
            again.
    """

    plan: Plan | None = None
    continues: Annotated[str, Field(max_length=64)] | None = None


class Pause(Frozen):
    """Hold the run after the present block, with the excitation at zero."""

    kind: Literal["pause"] = "pause"


class Resume(Frozen):
    """Go on after a pause."""

    kind: Literal["resume"] = "resume"


class Repeat(Frozen):
    """Measure one frequency again; the new block replaces the old one in what follows.

    Attributes:
        frequency_hz: one of the plan that has been recorded.
        level: name of the drive's level; None: every level it was recorded at.
    """

    kind: Literal["repeat"] = "repeat"
    frequency_hz: PositiveFloat
    level: str | None = None


class Drop(Frozen):
    """Leave one hit out; it is asked for again while the run goes on. It answers "no" where the run waits to know.

    Attributes:
        n: number of the block in the run, from 0.
        reason: kept with the block.
    """

    kind: Literal["drop"] = "drop"
    n: Annotated[int, Field(ge=0)]
    reason: Annotated[str, Field(max_length=400)] = "dropped by the operator"


class Accept(Frozen):
    """Let a hit count that was rejected or dropped; it is not asked for again. While its hit is still requested only.

    Where the run waits to know whether a hit counts, it answers "yes".

    Attributes:
        n: number of the block in the run, from 0.
        reason: kept with the block.
    """

    kind: Literal["accept"] = "accept"
    n: Annotated[int, Field(ge=0)]
    reason: Annotated[str, Field(max_length=400)] = "accepted at the bench"


class Stop(Frozen):
    """End the run; what it has is valid."""

    kind: Literal["stop"] = "stop"


class Abort(Frozen):
    """End the run; what it has is kept and marked as invalid."""

    kind: Literal["abort"] = "abort"


Command = Annotated[Pause | Resume | Repeat | Drop | Accept | Stop | Abort, Field(discriminator="kind")]


class RunView(Frozen):
    """A run.

    Attributes:
        id: its name, which sorts by time.
        campaign: the campaign it belongs to; None for a run made without the service.
        rig: the rig's id; None as before.
        test: impact or sine.
        state: where it stands or how it ended.
        reason: why it ended so.
        code: code of the error it ended with, else "".
        valid: False once aborted.
        legal: states that may follow.
        plan: what was asked for.
        operator: who began it.
        continues: the run whose good blocks it takes over.
        created_utc: for people.
        ended_utc: "" while it goes on.
        blocks: kept so far, rejected ones with them.
        accepted: that count.
        rate_hz: None until the bench was configured.
        archived_utc: when it, or its campaign, was archived; "" if it is not.
        deleted_utc: when it, or its campaign, was deleted; "" if it is not.
        purge_utc: until when it can be restored; from then on its samples are deleted.
        rig_hash: SHA-256 of the rig's JSON as it was then.
    """

    id: str
    campaign: str | None
    rig: str | None
    test: Test
    state: RunState
    reason: str
    code: str
    valid: bool
    legal: tuple[RunState, ...]
    plan: Plan
    operator: str
    continues: str | None
    created_utc: str
    ended_utc: str
    blocks: int
    accepted: int
    rate_hz: float | None
    archived_utc: str = ""
    deleted_utc: str = ""
    purge_utc: str = ""
    rig_hash: str = ""


class BlockView(Frozen):
    """A block on the disk. `crc32` is that of its samples as (channels, count), C order, little-endian.

    Attributes:
        run: its name.
        n: number in the run, from 0.
        name: unique in the run.
        first_sample: place of the first sample in the device's own count.
        count: samples per channel.
        crc32: of the samples, as bytes.
        utc: when it was recorded, for people.
        drive_point: point of the hit or of the shaker; None if unknown.
        level: of the drive; None in an impact test.
        frequency_hz: of the drive; None but in a sine test.
        overload: names of the channels beyond their range.
        facts: what was measured when it was recorded, by name: of a hit `peak_n`, `contact_s`, `second_ratio`,
            `drop_db`, of a sine `force_n`.
        accepted: whether it counts now: the operator's last verdict, else the acquisition's.
        reason: why it does not, or who said so.
    """

    run: str
    n: int
    name: str
    first_sample: int
    count: int
    crc32: int
    accepted: bool
    reason: str
    utc: str
    drive_point: int | None
    level: str | None
    frequency_hz: float | None
    overload: tuple[str, ...]
    facts: dict[str, float | str]


class Verdict(Frozen):
    """Whether a block counts, by an operator.

    Attributes:
        accepted: whether it counts from now on.
        reason: kept with the block.
    """

    accepted: Truth
    reason: Annotated[str, Field(max_length=400)] = ""


class PlanCheck(Frozen):
    """Whether a rig could run a plan.

    Attributes:
        problems: what is wrong with it, in plain sentences; none: it is possible.
        blocks: it would record; 0 where it is not possible.
        duration_s: about how long it would take, with the usual pace of an operator; 0 where it is not possible.
    """

    problems: tuple[str, ...]
    blocks: int
    duration_s: float


class BlockForce(Frozen):
    """The force of a block.

    Attributes:
        run: it is of.
        n: number of the block.
        rate_hz: of the samples.
        force_n: (samples,) in N, less its median.
        spectrum_hz: (lines,) in Hz.
        spectrum_n_s: (lines,) amplitude of the Fourier transform, in N s.
    """

    run: str
    n: int
    rate_hz: float
    force_n: RealArray
    spectrum_hz: RealArray
    spectrum_n_s: RealArray
