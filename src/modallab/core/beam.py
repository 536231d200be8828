"""What is believed of the structure: the beam, how well it is known and put together, and its damping."""

from typing import Annotated, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from modallab.core.frozen import Frozen, NonNegative, Positive

FORCE_SHARE = 0.5
"""Of an accelerometer's tolerance: what the force transducer's sensitivity is uncertain by."""
RESPONSE = 0.02
"""Share of the response below which a difference does not matter, where a rig file does not say it."""


class Beam(Frozen):
    """A prismatic cantilever, clamped at x = 0.

    Attributes:
        length_m: distance from the clamp to the free end.
        width_m: across the direction of bending.
        thickness_m: in the direction of bending.
        youngs_modulus_pa: Young's modulus of the material, E.
        density_kg_m3: density of the material, rho.
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
    """Standard deviations of the stated parameters of the bench, relative unless the name has a unit.

    The first three have a default; the others are fixed unless the rig file states them.

    Attributes:
        youngs_modulus: deviation of E.
        thickness: deviation of the beam's thickness.
        density: deviation of rho.
        sensitivity: deviation of each accelerometer's sensitivity; half of it for the force transducer.
        position_m: deviation of each accelerometer's place along the beam.
        hit_position_m: deviation of each hit's place along the beam.
        hit_gain: deviation of each hit's force on the beam over the hammer's reading.
        clamp_compliance: rotational compliance of the root in L / EI; positive.
        sensor_mass_kg: mass of cable and glue at each accelerometer; positive.
        stiffness_field: deviation of the factors 1 + a cos(k pi x / L) on EI, k = 1 to 3.
        mass_field: the same for rho A.
        stiffness_drift: deviation of the change of EI from the first record to the last.
        damper_n_s_per_m: one damper to ground at an unknown place; positive.
        shaker_mass_kg: of parts attached to the beam at the shaker point in the sine test; positive.
        stinger_rotation: rotational stiffness of the stinger, in EI / L; positive.
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
    """Prior of the damping ratio of every mode: log-normal about `guess`.

    Attributes:
        guess: most probable damping ratio.
        factor: one standard deviation, as a factor.
        meaning: in words.
    """

    guess: Positive = 0.006
    factor: Annotated[float, Field(gt=1, allow_inf_nan=False)] = 2.0
    meaning: str = "every mode, log-normal"
