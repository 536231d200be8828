"""What the service says by itself: events besides those of a run, and what stands before live arrays."""

from typing import Annotated, Any, Literal

from pydantic import Field

from modallab.core.documents.results import JobKind, JobState
from modallab.core.documents.rigs import RigState
from modallab.core.events import Event
from modallab.core.frf import FrfQuantity
from modallab.core.frozen import Frozen


class RigChanged(Frozen):
    """The state of a rig's process has changed.

    Attributes:
        rig: id of the rig.
        state: present state.
        error: reason if the rig is unavailable, otherwise "".
    """

    kind: Literal["rig"] = "rig"
    rig: str
    state: RigState
    error: str


class RigTripped(Frozen):
    """A rig was tripped.

    Attributes:
        rig: id of the rig.
        reason: in words.
        operator: name of the operator.
    """

    kind: Literal["tripped"] = "tripped"
    rig: str
    reason: str
    operator: str


class RigReset(Frozen):
    """A rig may be driven again.

    Attributes:
        rig: id of the rig.
        reason: in words.
        operator: name of the operator.
    """

    kind: Literal["reset"] = "reset"
    rig: str
    reason: str
    operator: str


class JobChanged(Frozen):
    """The state or progress of a job has changed.

    Attributes:
        job: its name.
        of: kind of the job.
        state: present state.
        progress: 0 to 1.
        stage: present stage in words; "" if none.
        inputs: names of its runs.
        error: reason of a failure; None without one.
    """

    kind: Literal["job"] = "job"
    job: str
    of: JobKind | str
    state: JobState
    progress: float
    stage: str = ""
    inputs: tuple[str, ...]
    error: str | None


class BlockJudged(Frozen):
    """A block of an ended run has a new verdict.

    Attributes:
        run: name of the run.
        n: number of the block.
        operator: name of the operator.
        accepted: whether the block is valid from now on.
        reason: reason.
    """

    kind: Literal["verdict"] = "verdict"
    run: str
    n: int
    operator: str
    accepted: bool
    reason: str


class QueueChanged(Frozen):
    """The state of a rig's queue, or of an item, has changed.

    Attributes:
        rig: id of the rig.
        state: state of the item, or `paused`, `resumed` and others of the queue.
        item: id of the item; "" for the queue.
        run: name of the item's run; "" if none.
        reason: reason.
        operator: name of the operator; "" if none.
        drive: whether the consent permits tests that move the output.
        at_bench: whether the consent permits impact tests.
    """

    kind: Literal["queue"] = "queue"
    rig: str
    state: str
    item: str = ""
    run: str = ""
    reason: str = ""
    operator: str = ""
    drive: bool | None = None
    at_bench: bool | None = None

    def content(self) -> dict[str, Any]:
        """What is said of it: nothing of what does not concern it."""
        return {"kind": self.kind} | self.model_dump(exclude_unset=True)


class ArchiveChanged(Frozen):
    """A campaign or a run was archived, deleted or restored.

    Attributes:
        campaign: id of the campaign; "" for a run.
        run: name of the run; "" for a campaign.
        state: present state.
        operator: name of the operator.
    """

    kind: Literal["set_aside"] = "set_aside"
    campaign: str = ""
    run: str = ""
    state: str
    operator: str


AnyEvent = Annotated[
    Event | RigChanged | RigTripped | RigReset | JobChanged | BlockJudged | QueueChanged | ArchiveChanged,
    Field(discriminator="kind"),
]
"""The content of an event."""


class LiveHeader(Frozen):
    """What stands before every live array.

    Attributes:
        dtype: data type of the array, in NumPy's notation.
        shape: shape of the array.
        rig: id of the rig.
        run: name of the run; "" between runs.
        position: index of the first sample, from 0 without a gap.
        first_sample: the same index in the device's own count.
        lost: number of earlier samples that are no longer available.
        rate_hz: sampling rate of the device.
        channels: names of the array's rows.
        units: units of the channels.
        ended: whether this is the last message.
    """

    dtype: str
    shape: tuple[int, ...]
    rig: str
    run: str
    position: int
    first_sample: int
    lost: int
    rate_hz: float
    channels: tuple[str, ...]
    units: tuple[str, ...]
    ended: bool


class SamplesHeader(LiveHeader):
    """Header of (channels, n) samples in counts.

    Attributes:
        scale: unit per count of each channel.
        overload: names of the overloaded channels.
    """

    scale: tuple[float, ...] = ()
    overload: tuple[str, ...] = ()


class EnvelopeHeader(LiveHeader):
    """Header of (channels, 2, columns) extremes in units.

    Attributes:
        width: samples in a column.
        overload: columns with overload, by channel.
    """

    width: int | None = None
    overload: dict[str, tuple[int, ...]] = Field(default_factory=dict)


class EvenFrequencies(Frozen):
    """Evenly spaced lines.

    Attributes:
        first: frequency of the first line, in Hz.
        step: spacing of the lines, in Hz.
        count: number of lines.
    """

    first: float
    step: float
    count: int


class LiveFrfHeader(Frozen):
    """Header of (1 or 2, outputs, lines) mobility, and coherence with averaged blocks.

    Attributes:
        dtype: data type of the array, in NumPy's notation.
        shape: shape of the array.
        run: name of the run.
        quantity: mobility.
        unit: unit of the values.
        input_point: driven point; None if unknown.
        averages: number of averaged blocks.
        outputs: channel names.
        output_points: points of the outputs; None if unknown.
        coherence: whether the array contains coherence.
        frequency_hz: frequencies of the lines.
    """

    dtype: str
    shape: tuple[int, ...]
    run: str
    quantity: FrfQuantity
    unit: str
    input_point: int | None
    averages: int
    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    coherence: bool
    frequency_hz: EvenFrequencies | tuple[float, ...]
