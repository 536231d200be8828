"""What a device delivered, block by block, and a campaign of such blocks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.core.units import Test

Ramp = Literal["straight", "cosine"]


ALSO_DRIVEN = "also_driven"
"""Name of the fact of a stored block that lists the points of the shakers beside the first one."""


def note_other_shakers(points: tuple[int, ...]) -> dict[str, str]:
    """What a stored block says of the shakers beside the first one; nothing where there was none."""
    return {ALSO_DRIVEN: " ".join(map(str, points))} if points else {}


def other_driven_points(facts: Mapping[str, float | str]) -> tuple[int, ...]:
    """Points of the shakers beside the first one, by what a stored block says."""
    return tuple(int(point) for point in str(facts.get(ALSO_DRIVEN, "")).split())


@dataclass(frozen=True, eq=False, slots=True)
class Block:
    """One stretch of simultaneous samples, as the device delivered them.

    Attributes:
        name: name of the record, unique in its campaign.
        test: which test it belongs to.
        order: place in the campaign's order of time.
        rate_hz: rate at which the samples stand.
        samples: (channels, n), whole counts or real numbers, never scaled; channels in rig order.
        scale: (channels,) unit per count.
        units: (channels,) unit after the scale: "V", or an engineering unit if the source held one.
        channels: (channels,) names, those of the rig.
        drive_point: point of the hit or of the shaker; None if unknown.
        also_driven: points that other shakers drove at the same time.
        level: name of the drive level in a sine test.
        frequency_hz: frequency the generator was set to in a sine test.
        first_sample: index of the first sample in the device's own count.
        requested_rate_hz: what was asked of the device; None if unknown.
        actual_rate_hz: what its clock gave; None if unknown.
        overload: (channels,) whether the device reported a channel beyond its range; None if it cannot report it.
        history_s: from the start of a sine, out of rest, to the first sample, by the samples' count; None if unknown.
        ramp_s: how long that sine took to rise; None if unknown.
        ramp: along what it rose; None if unknown.
    """

    name: str
    test: Test
    order: int
    rate_hz: float
    samples: NDArray[np.int16] | NDArray[np.int32] | NDArray[np.float32] | NDArray[np.float64]
    scale: NDArray[np.float64]
    units: tuple[str, ...]
    channels: tuple[str, ...]
    drive_point: int | None = None
    level: str | None = None
    frequency_hz: float | None = None
    first_sample: int = 0
    requested_rate_hz: float | None = None
    actual_rate_hz: float | None = None
    overload: tuple[bool, ...] | None = None
    history_s: float | None = None
    ramp_s: float | None = None
    ramp: Ramp | None = None
    also_driven: tuple[int, ...] = ()

    @property
    def driven_points(self) -> tuple[int | None, ...]:
        """Points of all forces that drove, the first shaker's first."""
        return (self.drive_point, *self.also_driven)

    @property
    def n_samples(self) -> int:
        """Samples per channel."""
        return int(self.samples.shape[1])

    @property
    def duration_s(self) -> float:
        """Length of the block in s: n / rate."""
        return self.n_samples / self.rate_hz

    def with_channels(self, rows: Sequence[int]) -> "Block":
        """The block with these channels only, in this order."""
        kept = list(rows)
        return replace(
            self,
            samples=self.samples[kept],
            scale=self.scale[kept],
            units=tuple(self.units[row] for row in kept),
            channels=tuple(self.channels[row] for row in kept),
            overload=None if self.overload is None else tuple(self.overload[row] for row in kept),
        )


@dataclass(frozen=True, eq=False, slots=True)
class Campaign:
    """The recordings of one session at the bench, with the rig they were made on.

    Attributes:
        rig: description of the bench.
        blocks: in the order of time.
        frfs: FRFs that came as such, from a source that holds no time records.
        provenance: what else the source said (seeds, plan, code version, units), as text.
        source: file or folder it was read from, for messages.
    """

    rig: Rig
    blocks: tuple[Block, ...]
    frfs: tuple[Frf, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict[str, str])
    source: str = ""

    def of(self, test: Test) -> tuple[Block, ...]:
        """The blocks of one test, in the order of time."""
        return tuple(sorted((b for b in self.blocks if b.test == test), key=lambda b: b.order))
