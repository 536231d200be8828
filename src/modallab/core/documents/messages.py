"""What the service says by itself: events besides those of a run, and what stands before live arrays."""

from typing import Annotated, Any, Literal

from pydantic import Field

from modallab.core.documents.results import JobKind, JobState
from modallab.core.documents.rigs import RigState
from modallab.core.events import Event
from modallab.core.frf import FrfQuantity
from modallab.core.frozen import Frozen


class RigChanged(Frozen):
    """A rig's process is in another state.

    Attributes:
        rig: id of the rig.
        state: it is in now.
        error: why it is unavailable, else "".
    """

    kind: Literal["rig"] = "rig"
    rig: str
    state: RigState
    error: str


class Tripped(Frozen):
    """A rig was stopped in an emergency.

    Attributes:
        rig: id of the rig.
        reason: in words.
        operator: who stopped it.
    """

    kind: Literal["tripped"] = "tripped"
    rig: str
    reason: str
    operator: str


class Reset(Frozen):
    """A rig may be driven again.

    Attributes:
        rig: id of the rig.
        reason: in words.
        operator: who reset it.
    """

    kind: Literal["reset"] = "reset"
    rig: str
    reason: str
    operator: str


class JobChanged(Frozen):
    """A job goes on.

    Attributes:
        job: its name.
        of: its kind.
        state: it is in now.
        progress: 0 to 1.
        stage: what is being done, in words; "" where nothing is.
        inputs: runs it works on.
        error: why it failed; None if it did not.
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
    """Somebody has judged a block of a run that had ended.

    Attributes:
        run: its name.
        n: number of the block.
        operator: who judged.
        accepted: whether it counts from now on.
        reason: why.
    """

    kind: Literal["verdict"] = "verdict"
    run: str
    n: int
    operator: str
    accepted: bool
    reason: str


class QueueChanged(Frozen):
    """A rig's queue, or an item of it, is in another state.

    Attributes:
        rig: id of the rig.
        state: of the item, or `paused`, `resumed` and the like of the queue.
        item: id of the item; "" where the queue is meant.
        run: name of the item's run; "" where there is none.
        reason: why.
        operator: who did it; "" where nobody did.
        drive: of a consent, whether tests that move the output may begin.
        at_bench: of a consent, whether impact tests may.
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


class SetAsideChanged(Frozen):
    """A campaign or a run was archived, deleted or restored.

    Attributes:
        campaign: id of the campaign; "" where a run is meant.
        run: name of the run; "" where a campaign is meant.
        state: it is in now.
        operator: who did it.
    """

    kind: Literal["set_aside"] = "set_aside"
    campaign: str = ""
    run: str = ""
    state: str
    operator: str


AnyEvent = Annotated[
    Event | RigChanged | Tripped | Reset | JobChanged | BlockJudged | QueueChanged | SetAsideChanged,
    Field(discriminator="kind"),
]
"""The content of an event."""


class LiveAbout(Frozen):
    """What stands before every live array.

    Attributes:
        dtype: of the array, as NumPy writes it.
        shape: of the array.
        rig: id of the rig.
        run: name of the run; "" where none is on.
        position: of the first sample, counted from 0 without a hole.
        first_sample: the same in the device's own count.
        lost: samples before it that nobody can have any more.
        rate_hz: of the device.
        channels: names of the array's rows.
        units: of the channels.
        ended: whether nothing comes after this.
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


class SamplesAbout(LiveAbout):
    """Before (channels, n) samples in counts.

    Attributes:
        scale: unit per count of each channel.
        overload: names of the channels that were beyond their range.
    """

    scale: tuple[float, ...] = ()
    overload: tuple[str, ...] = ()


class EnvelopeAbout(LiveAbout):
    """Before (channels, 2, columns) extremes in units.

    Attributes:
        width: samples of a column.
        overload: by channel the columns in which it was beyond its range.
    """

    width: int | None = None
    overload: dict[str, tuple[int, ...]] = Field(default_factory=dict)


class Axis(Frozen):
    """Lines that are evenly apart.

    Attributes:
        first: frequency of the first one, in Hz.
        step: between two, in Hz.
        count: how many.
    """

    first: float
    step: float
    count: int


class FrfAbout(Frozen):
    """Before (1 or 2, outputs, lines) mobility, and coherence where blocks are averaged.

    Attributes:
        dtype: of the array, as NumPy writes it.
        shape: of the array.
        run: name of the run.
        quantity: mobility.
        unit: of its values.
        input_point: that was driven; None if unknown.
        averages: blocks averaged.
        outputs: channel names.
        output_points: None where unknown.
        coherence: whether the array holds it.
        frequency_hz: of the lines.
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
    frequency_hz: Axis | tuple[float, ...]
