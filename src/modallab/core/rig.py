"""What stands on the bench: beam, points, channels, converter, limits, tolerances."""

from collections.abc import Collection, Mapping, Sequence
from typing import Annotated, Literal, Self, cast

from pydantic import Field, PositiveInt, model_validator

from modallab.core.beam import FORCE_SHARE, Beam, DampingPrior, Tolerance
from modallab.core.channel import Channel, Converter, Direction, Point
from modallab.core.effect import Effect, Revision
from modallab.core.errors import RigError
from modallab.core.field_errors import reject_problems
from modallab.core.frozen import Frozen, Positive, is_not_stated
from modallab.core.hardware import Calibration, Excitation, Shaker, Synchronisation
from modallab.core.rig_checks import inconsistent_fields
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
    """Limits of the excitation, needed to drive.

    Attributes:
        drive_v: amplitude of the drive of each shaker.
        slew_v_per_s: steepest slope of the drive.
        force_n: force of every force channel, either sign.
        acceleration_m_s2: acceleration of every channel, either sign.
        max_burst_s: longest burst.
        velocity_m_s: velocity of every response, either sign; measured, or integrated from the acceleration.
        displacement_m: the same for the displacement.
        stroke_m: displacement of each shaker, either way from its middle; a response must be at its point.
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
    """Description of the bench by its operator.

    Attributes:
        name: name of the bench.
        model: kind of structure.
        bench: address of the bench; None: given when it is opened.
        beam: beam; None if it is not described.
        tolerance: standard deviations of the stated parameters.
        damping_ratio: prior of the damping ratio.
        gravity_axis: direction of gravity.
        drive_direction: direction of positive force.
        points: points of sensors and hits.
        lines: pairs of points joined in drawings.
        surfaces: points around each face, shaded in drawings.
        channels: channels, including the force channel; with `model: unknown` there may be none.
        converter: converter of all channels; None: that of the device.
        shaker_point: point of the shaker; None: no shaker.
        limits: limits of the excitation; None: driving is not allowed.
        excitation: drive of the shaker; None: not stated.
        shakers: further shakers, each with its own force channel.
        history: calibrations, the oldest first.
        synchronisation: synchronisation of several devices; None: one device.
        revisions: effects added to the simulation of this bench, the oldest first.
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
    lines: tuple[tuple[PositiveInt, PositiveInt], ...] = Field(default=(), exclude_if=is_not_stated)
    surfaces: tuple[Surface, ...] = Field(default=(), exclude_if=is_not_stated)
    channels: Annotated[tuple[Channel, ...], Field(min_length=1)]
    converter: Converter | None = None
    shaker_point: PositiveInt | None = None
    limits: Limits | None = None
    excitation: Excitation | None = None
    shakers: tuple[Shaker, ...] = Field(default=(), exclude_if=is_not_stated)
    history: tuple[Calibration, ...] = ()
    synchronisation: Synchronisation | None = Field(default=None, exclude_if=is_not_stated)
    revisions: tuple[Revision, ...] = Field(default=(), exclude_if=is_not_stated)

    @model_validator(mode="before")
    @classmethod
    def _read_force_direction(cls, content: object) -> object:
        return _with_force_direction(cast("Mapping[str, object]", content)) if isinstance(content, Mapping) else content

    @model_validator(mode="after")
    def _check(self) -> Self:
        reject_problems(inconsistent_fields(self.model_dump()))
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
