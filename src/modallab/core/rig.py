"""What stands on the bench: beam, points, channels, converter, limits, tolerances."""

from collections.abc import Mapping, Sequence
from datetime import date
from typing import Annotated, Literal, Self, cast

from pydantic import (
    Field,
    PositiveFloat,
    PositiveInt,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from modallab.core.effect import Effect, Revision
from modallab.core.errors import RigError
from modallab.core.frozen import Frozen, unstated
from modallab.core.hardware import Calibration, Excitation, Shaker, Synchronisation
from modallab.core.metrology import Certificate
from modallab.core.rig_checks import channel_problems, cross_problems
from modallab.core.rig_problem import Problem
from modallab.core.units import BROADBAND, Quantity, Test
from modallab.core.versions import RIG

Direction = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[PositiveFloat, Field(allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


Surface = Annotated[tuple[PositiveInt, ...], Field(min_length=3)]
FORCE_SHARE = 0.5
"""Of an accelerometer's tolerance: what the force transducer's sensitivity is uncertain by."""
RESPONSE = 0.02
"""Share of the response below which a difference does not matter, where a rig file does not say it."""


def _at_zero(value: object) -> bool:
    """Whether a coordinate is where points on a beam have it: then it is not written."""
    return value == 0


class Beam(Frozen):
    """A prismatic cantilever, clamped at x = 0.

    Attributes:
        length_m: from the clamp to the free end.
        width_m: across the direction of bending.
        thickness_m: in the direction of bending.
        youngs_modulus_pa: of the material, E.
        density_kg_m3: of the material, rho.
        clamp: in words; a number followed by `EI/L` is the root's rotational spring, without one the root is
            rigid.
    """

    length_m: Positive
    width_m: Positive
    thickness_m: Positive
    youngs_modulus_pa: Positive
    density_kg_m3: Positive
    clamp: str = "rigid at x = 0"

    @property
    def bending_stiffness_n_m2(self) -> float:
        """EI."""
        return self.youngs_modulus_pa * self.width_m * self.thickness_m**3 / 12

    @property
    def mass_kg(self) -> float:
        """Of the whole beam."""
        return self.density_kg_m3 * self.width_m * self.thickness_m * self.length_m


class Tolerance(Frozen):
    """One standard deviation of what is believed about the bench, relative unless the name holds a unit.

    The first three have a value where a rig file states none; of the others none is free unless it is stated.

    Attributes:
        youngs_modulus: of E.
        thickness: of the beam's thickness.
        density: of rho.
        sensitivity: of each accelerometer; half of it of the force transducer.
        position_m: of each accelerometer along the beam.
        hit_position_m: of each hit along the beam.
        hit_gain: of what the beam gets of each hit over what the hammer reads.
        clamp_compliance: rotation of the root in L / EI; positive.
        sensor_mass_kg: of cable and glue at each accelerometer; positive.
        stiffness_field: of the factors 1 + a cos(k pi x / L) on EI, k = 1 to 3.
        mass_field: the same on rho A.
        stiffness_drift: of EI from the first record to the last.
        damper_n_s_per_m: of one damper to ground somewhere; positive.
        shaker_mass_kg: of what hangs on the beam at the shaker point in the sine test; positive.
        stinger_rotation: of the rotational spring there, in EI / L; positive.
        meaning: in words.
        response: share of the response below which a difference between simulation and bench does not matter.
    """

    youngs_modulus: NonNegative = 0.012
    thickness: NonNegative = 0.003
    density: NonNegative = 0.003
    sensitivity: NonNegative = 0.01
    position_m: NonNegative = 0.0
    hit_position_m: NonNegative = 0.0
    hit_gain: NonNegative = 0.0
    clamp_compliance: NonNegative = 0.0
    sensor_mass_kg: NonNegative = 0.0
    stiffness_field: NonNegative = 0.0
    mass_field: NonNegative = 0.0
    stiffness_drift: NonNegative = 0.0
    damper_n_s_per_m: NonNegative = 0.0
    shaker_mass_kg: NonNegative = 0.0
    stinger_rotation: NonNegative = 0.0
    meaning: str = "one standard deviation, relative"
    response: Annotated[float, Field(gt=0, lt=1, allow_inf_nan=False)] = RESPONSE

    @classmethod
    def usual(cls) -> Self:
        """What a bench of this kind is off where people take ordinary care."""
        return cls(
            youngs_modulus=0.012,
            thickness=0.003,
            density=0.003,
            sensitivity=0.01,
            position_m=5e-4,
            hit_position_m=2e-3,
            hit_gain=4e-3,
            clamp_compliance=2e-3,
            sensor_mass_kg=3e-4,
            stiffness_field=3e-3,
            mass_field=2e-3,
            stiffness_drift=5e-4,
            damper_n_s_per_m=0.5,
            shaker_mass_kg=1e-3,
            stinger_rotation=4e-3,
        )

    @property
    def stated(self) -> bool:
        """Whether the rig file states any."""
        return bool(self.model_fields_set - {"meaning", "response"})

    @property
    def of_assembly(self) -> bool:
        """Whether it says how well the bench is put together, not only how well beam and sensors are known."""
        own = {"youngs_modulus", "thickness", "density", "sensitivity", "meaning", "response"}
        return any(getattr(self, name) for name in self.model_fields_set - own)

    @model_serializer(mode="wrap")
    def _as_stated(self, handler: SerializerFunctionWrapHandler) -> dict[str, object]:
        # What a rig file does not state must not look stated once the rig was stored and read again.
        return {name: value for name, value in handler(self).items() if name in self.model_fields_set}


class DampingPrior(Frozen):
    """What is believed about the damping ratio of every mode: log-normal about `guess`.

    Attributes:
        guess: the most likely damping ratio.
        factor: one standard deviation, as a factor.
        meaning: in words.
    """

    guess: Positive = 0.006
    factor: Annotated[float, Field(gt=1, allow_inf_nan=False)] = 2.0
    meaning: str = "every mode, log-normal"


class Point(Frozen):
    """A measurement point on the structure.

    Attributes:
        id: its number, unique on the rig.
        x_m: where it is; on a beam its distance from the clamp, elsewhere from wherever x is counted.
        y_m: the same along y; a beam lies along x.
        z_m: the same along z.
    """

    id: PositiveInt
    x_m: Finite
    y_m: Finite = Field(default=0.0, exclude_if=_at_zero)
    z_m: Finite = Field(default=0.0, exclude_if=_at_zero)


class Channel(Frozen):
    """One channel of the chain: transducer, preamplifier, input.

    Attributes:
        index: place in the rig, from 0.
        name: unique.
        quantity: what is measured.
        unit: of what is measured, as N, m/s^2 or g.
        point: number of the point where it stands.
        direction: of positive readings; the force channel's is the drive's unless it says otherwise.
        mass_kg: of the sensor.
        sensitivity_v_per_unit: one, or one per test.
        coupling: of the input; IEPE and bridge also feed the sensor.
        range_v: of the input, if it is not the converter's.
        serial: of the sensor.
        calibrated_on: day of its calibration.
        input: the device's own name of the input, such as `cDAQ1Mod1/ai0`; empty: the next one in order.
        excitation_v: feeds a bridge sensor.
        excitation_a: feeds an IEPE sensor.
        ac_corner_hz: corner of the first-order AC coupling; 0 for DC.
        delay_s: by how much the samples lag what the sensor felt, as a converter's digital filter does.
        skew_s: by how much later than channel 0 a multiplexer reads this channel.
        certificate: of the sensor's calibration.
    """

    index: Annotated[int, Field(ge=0)]
    name: Annotated[str, Field(min_length=1)]
    quantity: Quantity
    unit: str
    point: PositiveInt | None = None
    direction: Direction = "+z"
    mass_kg: NonNegative = 0.0
    sensitivity_v_per_unit: Finite | dict[Test, Finite] = 1.0
    coupling: Literal["DC", "AC", "IEPE", "bridge"] = "DC"
    range_v: Positive | None = None
    serial: str = ""
    calibrated_on: date | None = None
    input: str = ""
    excitation_v: Positive | None = None
    excitation_a: Positive | None = None
    ac_corner_hz: NonNegative = 0.0
    delay_s: NonNegative = 0.0
    skew_s: NonNegative = 0.0
    certificate: Certificate | None = Field(default=None, exclude_if=unstated)

    def sensitivity(self, test: Test) -> float:
        """Volts per unit in a test; the preamplifier may stand differently in each."""
        value = self.sensitivity_v_per_unit
        if isinstance(value, float | int):
            return float(value)
        if test not in value and test in BROADBAND and "sine" in value:
            # The shaker drives in both, and nobody turns the preamplifiers between.
            return value["sine"]
        if test not in value:
            raise RigError(
                f"no sensitivity for the {test} test, only for {', '.join(value) or 'none'}",
                where=f"channel {self.name}",
                remedy=f"add sensitivity_v_per_unit: {{{test}: ...}} to the rig file",
            )
        return value[test]

    @model_validator(mode="after")
    def _check(self) -> Self:
        _reject(channel_problems(self.model_dump()))
        return self


class Converter(Frozen):
    """The analog-to-digital converter behind every channel.

    Attributes:
        bits: resolution.
        range_v: full scale, either way.
        noise_rms_v: of one sample.
    """

    bits: Annotated[int, Field(ge=8, le=32)] = 16
    range_v: Positive = 10.0
    noise_rms_v: NonNegative = 0.0003

    @property
    def volts_per_count(self) -> float:
        """Volts of one count, full scale +-range_v."""
        return self.range_v / 2 ** (self.bits - 1)


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
    lines: tuple[tuple[PositiveInt, PositiveInt], ...] = Field(default=(), exclude_if=unstated)
    surfaces: tuple[Surface, ...] = Field(default=(), exclude_if=unstated)
    channels: Annotated[tuple[Channel, ...], Field(min_length=1)]
    converter: Converter | None = None
    shaker_point: PositiveInt | None = None
    limits: Limits | None = None
    excitation: Excitation | None = None
    shakers: tuple[Shaker, ...] = Field(default=(), exclude_if=unstated)
    history: tuple[Calibration, ...] = ()
    synchronisation: Synchronisation | None = Field(default=None, exclude_if=unstated)
    revisions: tuple[Revision, ...] = Field(default=(), exclude_if=unstated)

    @model_validator(mode="before")
    @classmethod
    def _read_force_direction(cls, content: object) -> object:
        return _with_force_direction(cast("Mapping[str, object]", content)) if isinstance(content, Mapping) else content

    @model_validator(mode="after")
    def _check(self) -> Self:
        _reject(cross_problems(self.model_dump()))
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

    @property
    def known_effects(self) -> tuple[Effect, ...]:
        """What the simulation of this bench carries: the effects of all its revisions."""
        return tuple(effect for revision in self.revisions for effect in revision.effects)

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


def _reject(problems: Sequence[Problem]) -> None:
    if problems:
        raise ValueError("\n".join(str(problem) for problem in problems))


def _with_force_direction(content: Mapping[str, object]) -> Mapping[str, object]:
    """The rig with the drive's direction in the force channel, where it has none of its own.

    Version 1 took no notice of the force channel's direction: whatever it says there, the drive's is meant.
    """
    old, channels = content.get("format_version") == 1, content.get("channels")
    if not isinstance(channels, Sequence) or isinstance(channels, str):
        return content
    drive = content.get("drive_direction", "+z")
    listed = [_along(channel, drive, old) for channel in cast("Sequence[object]", channels)]
    return {**content, "channels": listed, **({"format_version": RIG} if old else {})}


def _along(channel: object, drive: object, old: bool) -> object:
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
