"""What the catalogue knows of a run and of a block."""

from dataclasses import dataclass, field

from modallab.core.events import RunState
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.core.units import Test

ENDED: frozenset[RunState] = frozenset({"done", "failed", "aborted"})
"""States a run never leaves."""


@dataclass(frozen=True, slots=True)
class SamplingRates:
    """The rate that was asked for, what the clock gave, and what stands in the file, in Hz."""

    requested_hz: float
    actual_hz: float
    delivered_hz: float


@dataclass(frozen=True, slots=True)
class RunRecord:
    """One run, with all that is needed to read or repeat it.

    Attributes:
        id: its name, which sorts by time.
        test: which test the plan is.
        state: where the run stands or how it ended.
        reason: why it ended so.
        valid: False once aborted: the data are kept, and marked.
        plan: what was asked for.
        rig: the bench as believed.
        rig_hash: SHA-256 of the rig's JSON.
        bench_url: the address.
        facts: devices, seeds and whatever else the bench said of itself.
        code_version: version of modallab that recorded it.
        created_utc: for people; the samples count their own time.
        ended_utc: "" while the run goes on.
        rates: None until the bench was configured.
        dtype: NumPy name of the samples' type, little-endian; "" until then.
        scale: unit per count of each channel.
        units: unit after the scale of each channel.
    """

    id: str
    test: Test
    state: RunState
    reason: str
    valid: bool
    plan: Plan
    rig: Rig
    rig_hash: str
    bench_url: str
    facts: dict[str, str]
    code_version: str
    created_utc: str
    ended_utc: str
    rates: SamplingRates | None
    dtype: str
    scale: tuple[float, ...]
    units: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BlockNote:
    """What the acquisition says of a block when it hands it over.

    Attributes:
        name: name of the record.
        test: which test.
        first_sample: place of the first sample in the device's count.
        drive_point: point of the hit or of the shaker.
        level: name of the drive level.
        frequency_hz: what the generator was set to.
        accepted: False for a rejected hit, which is kept all the same.
        reason: why it was rejected, with the number.
        overload: names of the channels that were beyond their range.
        facts: what else was measured about it, such as the residual motion before it.
    """

    name: str
    test: Test
    first_sample: int
    drive_point: int | None = None
    level: str | None = None
    frequency_hz: float | None = None
    accepted: bool = True
    reason: str = ""
    overload: tuple[str, ...] = ()
    facts: dict[str, float | str] = field(default_factory=dict[str, float | str])


@dataclass(frozen=True, slots=True)
class BlockRecord:
    """One block: its note, and where its samples are.

    Attributes:
        run: the run it belongs to.
        n: its number in the run, from 0.
        offset: place of the first sample in the dataset.
        count: samples per channel.
        crc32: of the samples' bytes as (channels, count), C order, little-endian.
        monotonic_s: the recording machine's monotonic clock at the commit.
        utc: for people.
        note: what the acquisition said.
    """

    run: str
    n: int
    offset: int
    count: int
    crc32: int
    monotonic_s: float
    utc: str
    note: BlockNote
