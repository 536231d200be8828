"""What stands on the bench: beam, points, channels, converter, limits, tolerances."""

from collections.abc import Collection, Mapping, Sequence
from typing import Annotated, Literal, Self, cast

from pydantic import Field, PositiveInt, model_validator

from modallab.core.beam import FORCE_SHARE, Beam, DampingPrior, Tolerance
from modallab.core.channel import Channel, Converter, Direction, Point
from modallab.core.effect import Effect, Revision
from modallab.core.errors import RigError
from modallab.core.field_errors import reject_problems
from modallab.core.frozen import Frozen, Positive, is_unstated
from modallab.core.hardware import Calibration, Excitation, Shaker, Synchronisation
from modallab.core.rig_checks import cross_problems
from modallab.core.versions import RIG

__all__ = [
    "FORCE_SHARE",
    "Beam",
    "Channel",
    "Converter",
    "DampingPrior",
    "Direction",
    "Limits",
    "Point",
    "Rig",
    "Tolerance",
]

Surface = Annotated[tuple[PositiveInt, ...], Field(min_length=3)]


class Limits(Frozen):
    """What the excitation may never exceed. Needed to drive, not to read.

    Attributes:
        drive_v: amplitude of the drive, of each shaker's.
        slew_v_per_s: its steepest slope.
        force_n: of every force channel, either way.
        acceleration_m_s2: of every acceleration channel, either way.
        max_burst_s: how long a burst may last.
        velocity_m_s: of every response, either way; measured, or integrated from the acceleration.
        displacement_m: the same of the displacement.
        stroke_m: of each shaker, either way from its middle: the displacement at its point, where a response must be.
    """

    drive_v: Positive
    slew_v_per_s: Positive
    force_n: Positive
    acceleration_m_s2: Positive
    max_burst_s: Positive
    velocity_m_s: Positive | None = None
    displacement_m: Positive | None = None
    stroke_m: Positive | None = None


class Rig(Frozen):
    """The bench as the operator believes it to be.

    Attributes:
        name: of the bench.
        model: what kind of structure it is.
        bench: address of the bench; None: named when it is opened.
        beam: the structure; None where it is not described.
        tolerance: of what is believed.
        damping_ratio: what is believed of it.
        gravity_axis: where down is.
        drive_direction: of positive force.
        points: where sensors stand and hits land.
        lines: pairs of points that are joined where the structure is drawn.
        surfaces: points around a face each, which is shaded where the structure is drawn.
        channels: of the chain, the force channel among them; where nothing is known of the structure there may be none.
        converter: behind every channel; None: the device says.
        shaker_point: where the shaker drives; None: there is none.
        limits: of the excitation; None: nothing may be driven.
        excitation: what drives the shaker; None: nothing is said of it.
        shakers: those beside the first one, each with a force channel of its own.
        history: calibrations, the oldest first.
        synchronisation: how several devices sample as one; None: there is one.
        revisions: effects that the simulation of this bench has been given, the oldest first.
    """

    format_version: Literal[2] = RIG
    name: str
    model: Literal["cantilever", "unknown"] = "cantilever"
    bench: str | None = None
    beam: Beam | None = None
    tolerance: Tolerance = Tolerance()
    damping_ratio: DampingPrior = DampingPrior()
    gravity_axis: Direction = "-y"
    drive_direction: Direction = "+z"
    points: tuple[Point, ...] = ()
    lines: tuple[tuple[PositiveInt, PositiveInt], ...] = Field(default=(), exclude_if=is_unstated)
    surfaces: tuple[Surface, ...] = Field(default=(), exclude_if=is_unstated)
    channels: Annotated[tuple[Channel, ...], Field(min_length=1)]
    converter: Converter | None = None
    shaker_point: PositiveInt | None = None
    limits: Limits | None = None
    excitation: Excitation | None = None
    shakers: tuple[Shaker, ...] = Field(default=(), exclude_if=is_unstated)
    history: tuple[Calibration, ...] = ()
    synchronisation: Synchronisation | None = Field(default=None, exclude_if=is_unstated)
    revisions: tuple[Revision, ...] = Field(default=(), exclude_if=is_unstated)

    @model_validator(mode="before")
    @classmethod
    def _read_force_direction(cls, content: object) -> object:
        return _with_force_direction(cast("Mapping[str, object]", content)) if isinstance(content, Mapping) else content

    @model_validator(mode="after")
    def _check(self) -> Self:
        reject_problems(cross_problems(self.model_dump()))
        return self

    @property
    def force(self) -> Channel | None:
        """The first shaker's force transducer, and the hammer's; None where no force was measured."""
        others = {shaker.force for shaker in self.shakers}
        return next((c for c in self.channels if c.quantity == "force" and c.name not in others), None)

    @property
    def force_channel(self) -> Channel:
        """The first shaker's force transducer, and the hammer's.

        Raises:
            RigError: no force was measured.
        """
        if self.force is None:
            raise RigError(
                f"the rig {self.name!r} has no force channel",
                remedy="identify the responses alone (--response-only), or add the force channel to the rig file",
            )
        return self.force

    @property
    def forces(self) -> tuple[Channel, ...]:
        """The force transducer of each shaker, the first one's first; none where no force was measured."""
        by_name = {channel.name: channel for channel in self.channels}
        others = tuple(by_name[shaker.force] for shaker in self.shakers)
        return others if self.force is None else (self.force, *others)

    @property
    def shaker_points(self) -> tuple[int, ...]:
        """Where each shaker drives, in the order of `forces`; none where there is no shaker."""
        return () if self.shaker_point is None else (self.shaker_point, *(shaker.point for shaker in self.shakers))

    @property
    def responses(self) -> tuple[Channel, ...]:
        """All channels but the force, in rig order."""
        return tuple(c for c in self.channels if c.quantity != "force")

    def without(self, names: Collection[str]) -> "Rig":
        """The rig without these channels."""
        kept = [c for c in self.channels if c.name not in names]
        numbered = tuple(c.model_copy(update={"index": n}) for n, c in enumerate(kept))
        return self.model_copy(update={"channels": numbered}) if len(kept) < len(self.channels) else self

    def of_outputs(self, outputs: Collection[str]) -> "Rig":
        """The rig with its forces and these responses only."""
        return self.without({c.name for c in self.responses if c.name not in outputs})

    @property
    def known_effects(self) -> tuple[Effect, ...]:
        """What the simulation of this bench carries: the effects of all its revisions."""
        return tuple(effect for revision in self.revisions for effect in revision.effects)

    def sense_of(self, channel: Channel) -> float:
        """Sign of a reading over the motion along its axis. Along the drive it is 1: that reading has been turned."""
        across = channel.direction[1] != self.drive_direction[1]
        return -1.0 if across and channel.direction[0] == "-" else 1.0

    def x_of(self, point: int) -> float:
        """Distance of a point from the clamp, in m.

        Raises:
            RigError: no such point.
        """
        for candidate in self.points:
            if candidate.id == point:
                return candidate.x_m
        raise RigError(
            f"point {point} is not on the rig, which has {[p.id for p in self.points]}",
            remedy="add the point to the rig file",
        )


def _with_force_direction(content: Mapping[str, object]) -> Mapping[str, object]:
    """The rig with the drive's direction in the force channel, where it has none of its own.

    Version 1 took no notice of the force channel's direction: whatever it says there, the drive's is meant.
    """
    old, channels = content.get("format_version") == 1, content.get("channels")
    if not isinstance(channels, Sequence) or isinstance(channels, str):
        return content
    drive = content.get("drive_direction", "+z")
    listed = [_convert_direction(channel, drive, old) for channel in cast("Sequence[object]", channels)]
    return {**content, "channels": listed, **({"format_version": RIG} if old else {})}


def _convert_direction(channel: object, drive: object, old: bool) -> object:
    if isinstance(channel, Channel):
        stated = "direction" in channel.model_fields_set
        if channel.quantity != "force" or (stated and not old):
            return channel
        return channel.model_copy(update={"direction": drive})
    if not isinstance(channel, Mapping):
        return channel
    fields = cast("Mapping[str, object]", channel)
    if fields.get("quantity") != "force" or ("direction" in fields and not old):
        return fields
    return {**fields, "direction": drive}
