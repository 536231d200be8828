"""Campaigns, their runs and blocks, and what an operator may ask of a run."""

from typing import Annotated, Literal

from pydantic import Field, PositiveFloat

from modallab.core.events import RunState
from modallab.core.frozen import Frozen, RealArray, Truth
from modallab.core.plan import Plan
from modallab.core.units import Test

Name = Annotated[str, Field(min_length=1, max_length=120, pattern=r"^[^\x00-\x1f\x7f]+$")]
Note = Annotated[str, Field(max_length=4000)]


class CampaignRequest(Frozen):
    """A new campaign on a rig of this service.

    Attributes:
        name: name, which need not be unique.
        rig: id of the rig.
        note: remark in words.
    """

    name: Name
    rig: Annotated[str, Field(min_length=1, max_length=64)]
    note: Note = ""


class CampaignChange(Frozen):
    """Changes of a campaign; missing fields stay as before.

    Attributes:
        name: new name; None: unchanged.
        note: the new one; None: as it was.
    """

    name: Name | None = None
    note: Note | None = None


class CampaignView(Frozen):
    """A campaign.

    Attributes:
        id: id, made by the service.
        name: for people.
        note: remark in words.
        rig: id of the rig.
        operator: name of the operator who made it.
        created_utc: date and time of its creation.
        revision: revision number, which is the ETag.
        runs: names of its runs, the oldest first, without archived or deleted ones.
        archived_utc: date and time of archiving; "" if it is not archived.
        deleted_utc: date and time of deletion; "" if it is not deleted.
        purge_utc: end of the time in which it can be restored; then its samples are deleted.
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


class RunRequest(Frozen):
    """Request to start a run; with `continues` it takes over the good blocks of an ended run of the same campaign.

    Without a plan, it completes the plan of the continued run.

    Attributes:
        plan: plan of the run; None: the rest of the plan of the continued run.
        continues: ended run of the same campaign, whose good blocks are taken over; None: none.
    """

    plan: Plan | None = None
    continues: Annotated[str, Field(max_length=64)] | None = None


class PauseRun(Frozen):
    """Pause the run after the present block, with the excitation at zero."""

    kind: Literal["pause"] = "pause"


class ResumeRun(Frozen):
    """Continue after a pause."""

    kind: Literal["resume"] = "resume"


class RepeatFrequency(Frozen):
    """Measure one frequency again; the new block replaces the old one.

    Attributes:
        frequency_hz: recorded frequency of the plan.
        level: name of the drive's level; None: every recorded level.
    """

    kind: Literal["repeat"] = "repeat"
    frequency_hz: PositiveFloat
    level: str | None = None


class DropHit(Frozen):
    """Reject one hit; it is requested again during the run.

    Attributes:
        n: number of the block in the run, from 0.
        reason: remark stored with the block.
    """

    kind: Literal["drop"] = "drop"
    n: Annotated[int, Field(ge=0)]
    reason: Annotated[str, Field(max_length=400)] = "dropped by the operator"


class AcceptHit(Frozen):
    """Accept a rejected or dropped hit, which is then not requested again; only while its hit is still requested.

    If the run waits for a decision on a hit, this command accepts the hit.

    Attributes:
        n: number of the block in the run, from 0.
        reason: remark stored with the block.
    """

    kind: Literal["accept"] = "accept"
    n: Annotated[int, Field(ge=0)]
    reason: Annotated[str, Field(max_length=400)] = "accepted at the bench"


class StopRun(Frozen):
    """End the run; its blocks are valid."""

    kind: Literal["stop"] = "stop"


class AbortRun(Frozen):
    """End the run; its blocks are kept and marked as invalid."""

    kind: Literal["abort"] = "abort"


Command = Annotated[
    PauseRun | ResumeRun | RepeatFrequency | DropHit | AcceptHit | StopRun | AbortRun, Field(discriminator="kind")
]


class RunView(Frozen):
    """A run.

    Attributes:
        id: name, which sorts by time.
        campaign: id of the campaign; None for a run made without the service.
        rig: id of the rig; None for a run made without the service.
        test: impact or sine.
        state: present state, or the outcome.
        reason: reason of the outcome.
        code: error code of the outcome, otherwise "".
        valid: false after an abort.
        legal: possible next states.
        plan: what was asked for.
        operator: name of the operator who started it.
        continues: name of the continued run.
        created_utc: for people.
        ended_utc: date and time of its end; "" before.
        blocks: number of stored blocks, including rejected ones.
        accepted: number of accepted blocks.
        rate_hz: sampling rate; None until the bench is configured.
        archived_utc: date and time of archiving of the run or its campaign; "" if it is not archived.
        deleted_utc: date and time of deletion of the run or its campaign; "" if it is not deleted.
        purge_utc: end of the time in which it can be restored; then its samples are deleted.
        rig_hash: SHA-256 of the rig's JSON at that time.
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
        run: name of the run.
        n: number of the block in the run, from 0.
        name: name, unique in the run.
        first_sample: index of the first sample in the device's own count.
        count: samples per channel.
        crc32: checksum of the samples, as bytes.
        utc: date and time of the recording.
        drive_point: point of the hit or of the shaker; None if unknown.
        level: level of the drive; None in an impact test.
        frequency_hz: frequency of the drive; None except in a sine test.
        overload: names of the overloaded channels.
        facts: measured values by name: of a hit `peak_n`, `contact_s`, `second_ratio`, `drop_db`, of a sine
            `force_n`.
        accepted: whether the block is valid: by the operator's last verdict, otherwise by the acquisition.
        reason: reason of the rejection, or author of the verdict.
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


class BlockVerdict(Frozen):
    """An operator's verdict on a block.

    Attributes:
        accepted: whether the block is valid from now on.
        reason: remark stored with the block.
    """

    accepted: Truth
    reason: Annotated[str, Field(max_length=400)] = ""


class PlanCheck(Frozen):
    """Whether a rig could run a plan.

    Attributes:
        problems: sentences on what is wrong; empty: the plan is possible.
        blocks: number of blocks; 0 if the plan is not possible.
        duration_s: estimated duration, with the usual pace of an operator; 0 if the plan is not possible.
    """

    problems: tuple[str, ...]
    blocks: int
    duration_s: float


class BlockForce(Frozen):
    """The force of a block.

    Attributes:
        run: name of the run.
        n: number of the block.
        rate_hz: sampling rate.
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
