"""Runs, their blocks, and what an operator may ask of a run."""

from typing import Annotated, Literal

from pydantic import Field, PositiveFloat

from modallab.core.events import RunState
from modallab.core.frozen import Frozen, RealArray
from modallab.core.plan import Plan
from modallab.core.units import Test

Action = Literal["pause", "resume", "repeat", "drop", "accept", "stop", "abort"]


class RunNew(Frozen):
    """Begin a run; `continues` names an ended run of the same campaign whose good blocks it takes over.

    Without a plan, a run that continues another does what is left of that one's plan.
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
    """Measure one frequency again; the new block replaces the old one in what follows."""

    kind: Literal["repeat"] = "repeat"
    frequency_hz: PositiveFloat
    level: str | None = None


class Drop(Frozen):
    """Leave one hit out; it is asked for again while the run goes on."""

    kind: Literal["drop"] = "drop"
    n: Annotated[int, Field(ge=0)]
    reason: Annotated[str, Field(max_length=400)] = "dropped by the operator"


class Accept(Frozen):
    """Let a hit count that was rejected; it is not asked for again. While its hit is still requested only."""

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


class RunProgress(Frozen):
    """How far a run is."""

    done: int
    total: int
    what: str


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


class BlockView(Frozen):
    """A block on the disk. `crc32` is that of its samples as (channels, count), C order, little-endian.

    Attributes:
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
    """Whether a block counts, by an operator."""

    accepted: Annotated[bool, Field(strict=True)]
    reason: Annotated[str, Field(max_length=400)] = ""


class PlanCheck(Frozen):
    """Whether a rig could run a plan.

    Attributes:
        problems: what is wrong with it, in plain sentences; none: it is possible.
        blocks: it would record; 0 where it is not possible.
    """

    problems: tuple[str, ...]
    blocks: int


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
