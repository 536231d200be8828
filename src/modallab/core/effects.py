"""The catalogue of effects: names, parameters, SI units, ranges and stage.

Twin and simulator both speak it; neither shares more than these names with the other.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from pydantic import Field

from modallab.core.errors import FormatError
from modallab.core.frozen import Frozen
from modallab.core.rig import Beam
from modallab.core.units import Test

Stage = Literal["structure", "sensor", "acquisition", "excitation"]
PlaceKind = Literal["none", "all", "x", "root", "shaker", "channel", "force", "pair", "base", "hit", "impact"]
Scale = Literal["one", "EI/L", "EI/L^3", "m", "sqrt(EI m/L^3)", "L"]


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect.

    Attributes:
        name: its name in every file.
        unit: its SI unit; "" for a pure number.
        low: smallest magnitude worth a look, in `scale`.
        high: largest.
        scale: what `low` and `high` are multiples of; EI/L and so on are those of the beam, m its mass.
        signed: whether the number may have either sign (the range is then that of its magnitude).
    """

    name: str
    unit: str
    low: float
    high: float
    scale: Scale = "one"
    signed: bool = False

    def bounds(self, beam: Beam) -> tuple[float, float]:
        """Smallest and largest magnitude on this beam, SI."""
        factor = _SCALES[self.scale](beam)
        return self.low * factor, self.high * factor


@dataclass(frozen=True, slots=True)
class EffectKind:
    """One entry of the catalogue.

    Attributes:
        name: the effect's name in every file.
        stage: where in the chain it acts.
        parameters: in the order of the files.
        place: what its place is. x is a share of the beam's length, from the clamp. Channel numbers are those of the
            rig: 0 the force, k the accelerometer in row k.
        tests: the tests it shows in.
        linear: whether the bench with it still answers in proportion to the force.
        says: what it does, in one line, with the convention of its parameters.
    """

    name: str
    stage: Stage
    parameters: tuple[Parameter, ...]
    place: PlaceKind
    says: str
    tests: tuple[Test, ...] = ("impact", "sine")
    linear: bool = True

    def parameter(self, name: str) -> Parameter:
        """The parameter of this name.

        Raises:
            FormatError: there is none.
        """
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise FormatError(
            f"{self.name} has no parameter {name!r}",
            remedy=f"use {', '.join(p.name for p in self.parameters) or 'none: it has no parameters'}",
        )


Place = float | int | str | tuple[int, ...]


class Effect(Frozen):
    """An effect with its numbers: what the twin adds, what a diagnosis names."""

    effect: str
    parameters: dict[str, float] = Field(default_factory=dict[str, float])
    place: dict[str, Place] = Field(default_factory=dict[str, Place])

    @property
    def kind(self) -> EffectKind:
        """Its entry in the catalogue."""
        return kind_of(self.effect)


def kind_of(name: str) -> EffectKind:
    """The catalogue's entry of this name.

    Raises:
        FormatError: the catalogue has no such effect.
    """
    if name not in CATALOGUE:
        raise FormatError(f"no effect is called {name!r}", remedy=f"use one of {', '.join(sorted(CATALOGUE))}")
    return CATALOGUE[name]


def _bending_stiffness(beam: Beam) -> float:
    return beam.youngs_modulus_pa * beam.width_m * beam.thickness_m**3 / 12


def _mass(beam: Beam) -> float:
    return beam.density_kg_m3 * beam.width_m * beam.thickness_m * beam.length_m


_SCALES: dict[Scale, Callable[[Beam], float]] = {
    "one": lambda _: 1.0,
    "EI/L": lambda b: _bending_stiffness(b) / b.length_m,
    "EI/L^3": lambda b: _bending_stiffness(b) / b.length_m**3,
    "m": _mass,
    "sqrt(EI m/L^3)": lambda b: (_bending_stiffness(b) * _mass(b) / b.length_m**3) ** 0.5,
    "L": lambda b: b.length_m,
}

_STRUCTURE = (
    EffectKind(
        "clamp_rotation",
        "structure",
        (Parameter("k_rot", "N m/rad", 2.0, 2e5, "EI/L"),),
        "root",
        "the root turns against a spring k_rot",
    ),
    EffectKind(
        "clamp_translation",
        "structure",
        (Parameter("k_trans", "N/m", 20.0, 2e6, "EI/L^3"),),
        "root",
        "the root shifts across the beam against a spring k_trans, its rotation held",
    ),
    EffectKind(
        "clamp_friction",
        "structure",
        (
            Parameter("k_slip", "N m/rad", 2.0, 200.0, "EI/L"),
            Parameter("k_stick", "N m/rad", 10.0, 2000.0, "EI/L"),
            Parameter("moment_limit", "N m", 1e-6, 1e-1, "EI/L"),
        ),
        "root",
        "the root turns against k_slip and, beside it, k_stick - k_slip in series with a slider (Jenkins)",
        linear=False,
    ),
    EffectKind(
        "clearance",
        "structure",
        (Parameter("k_contact", "N m/rad", 1.0, 500.0, "EI/L"), Parameter("gap", "rad", 1e-6, 1e-2)),
        "root",
        "a free play at the root: beyond the gap a spring k_contact takes over",
        linear=False,
    ),
    EffectKind(
        "cubic_spring",
        "structure",
        (Parameter("k3", "N/m^3", 1e2, 1e10),),
        "x",
        "a spring to ground at x with the force k3 w^3",
        linear=False,
    ),
    EffectKind(
        "added_mass",
        "structure",
        (Parameter("mass", "kg", 1e-5, 1.0, "m"),),
        "x",
        "a point mass at x",
    ),
    EffectKind(
        "sensor_mass",
        "structure",
        (Parameter("mass_each", "kg", 1e-6, 0.1, "m"),),
        "all",
        "a point mass at every accelerometer",
    ),
    EffectKind(
        "stiffness_loss",
        "structure",
        (Parameter("EI_loss", "", 1e-4, 0.95),),
        "x",
        "EI falls by the share EI_loss at x and by less about it, as exp(-((x - x0) / (0.04 L))^2) (a crack)",
    ),
    EffectKind(
        "breathing_crack",
        "structure",
        (Parameter("EI_loss_open", "", 1e-4, 0.95),),
        "x",
        "a stiffness loss about x while the curvature is positive, none while it is negative",
        linear=False,
    ),
    EffectKind(
        "ground_spring",
        "structure",
        (Parameter("k", "N/m", 1e-4, 100.0, "EI/L^3"),),
        "x",
        "a spring to ground at x (a cable)",
    ),
    EffectKind(
        "local_damper",
        "structure",
        (Parameter("c", "N s/m", 1e-5, 10.0, "sqrt(EI m/L^3)"),),
        "x",
        "a viscous damper to ground at x",
    ),
    EffectKind(
        "air_drag",
        "structure",
        (Parameter("c2_total", "N s^2/m^2", 1e-2, 1e3),),
        "all",
        "a drag c2_total/L |v| v per length along the beam",
        linear=False,
    ),
    EffectKind(
        "thermal_drift",
        "structure",
        (Parameter("EI_drift", "", 1e-5, 0.3, signed=True),),
        "none",
        "EI has changed by the share EI_drift at the last record, about evenly over the order of time",
    ),
)

_SENSOR = (
    EffectKind(
        "gain_error",
        "sensor",
        (Parameter("gain", "", 1e-3, 2.0, signed=True),),
        "channel",
        "one channel reads gain times what it should; the range is that of |gain - 1|",
    ),
    EffectKind(
        "polarity", "sensor", (Parameter("sign", "", 1.0, 1.0, signed=True),), "channel", "one channel is turned over"
    ),
    EffectKind("swap", "sensor", (), "pair", "two channels are exchanged"),
    EffectKind(
        "noisy_channel",
        "sensor",
        (Parameter("factor", "", 1.3, 1000.0),),
        "channel",
        "the noise of one channel is factor times the converter's",
    ),
    EffectKind(
        "position_error",
        "sensor",
        (Parameter("dx", "m", 1e-5, 0.2, "L", signed=True),),
        "channel",
        "one accelerometer sits dx farther from the clamp than the rig file says",
    ),
    EffectKind(
        "ac_coupling",
        "sensor",
        (Parameter("corner_hz", "Hz", 1e-3, 20.0),),
        "all",
        "every accelerometer passes a first-order high-pass, -3 dB at corner_hz",
    ),
    EffectKind(
        "loose_mount",
        "sensor",
        (Parameter("hz", "Hz", 50.0, 5e3), Parameter("zeta", "", 1e-3, 0.3)),
        "channel",
        "one accelerometer stands on a mount with a resonance at hz and the damping ratio zeta",
    ),
    EffectKind(
        "clipping",
        "sensor",
        (Parameter("fraction_of_peak", "", 0.02, 0.999),),
        "channel",
        "one channel is cut at fraction_of_peak of what it would reach",
        linear=False,
    ),
    EffectKind(
        "force_gain",
        "sensor",
        (Parameter("gain", "", 1e-3, 2.0, signed=True),),
        "force",
        "the force channel reads gain times what it should; the range is that of |gain - 1|",
    ),
)

_ACQUISITION = (
    EffectKind(
        "channel_skew",
        "acquisition",
        (Parameter("seconds_per_channel", "s", 1e-9, 2e-4),),
        "all",
        "row k of the converter is sampled k seconds_per_channel later than row 0, the force",
    ),
    EffectKind(
        "trigger_delay",
        "acquisition",
        (Parameter("seconds", "s", 1e-8, 5e-3),),
        "all",
        "the force is stamped seconds late: beside its sample stands an acceleration of seconds later",
    ),
    EffectKind(
        "clock_error",
        "acquisition",
        (Parameter("relative", "", 1e-6, 0.1, signed=True),),
        "all",
        "the converter's true rate is (1 + relative) times the stated one",
    ),
    EffectKind(
        "mains_hum",
        "acquisition",
        (Parameter("volts", "V", 1e-5, 1.0), Parameter("hz", "Hz", 50.0, 60.0)),
        "all",
        "a sine at the mains frequency hz on every row, its amplitude volts (0.5 + 0.1 k) in row k",
    ),
)

_EXCITATION = (
    EffectKind(
        "hit_position",
        "excitation",
        (Parameter("dx", "m", 1e-5, 0.2, "L", signed=True),),
        "hit",
        "every hit lands dx farther from the clamp than said",
        ("impact",),
    ),
    EffectKind(
        "stinger_moment",
        "excitation",
        (Parameter("k_rot", "N m/rad", 1e-3, 1e3, "EI/L"),),
        "shaker",
        "the stinger holds the rotation of the shaker point with a spring k_rot",
        ("sine",),
    ),
    EffectKind(
        "shaker_mass",
        "excitation",
        (Parameter("mass", "kg", 1e-5, 2.0, "m"),),
        "shaker",
        "a mass at the shaker point on the beam's side of the force transducer",
        ("sine",),
    ),
    EffectKind(
        "floor_vibration",
        "excitation",
        (Parameter("rms_acc", "m/s^2", 1e-4, 10.0),),
        "base",
        "the base shakes with the acceleration rms_acc",
    ),
    EffectKind(
        "residual_ringing",
        "excitation",
        (Parameter("fraction", "", 1e-4, 3.0),),
        "impact",
        "the beam still rings from before when the hit falls",
        ("impact",),
    ),
)

CATALOGUE: dict[str, EffectKind] = {k.name: k for k in (*_STRUCTURE, *_SENSOR, *_ACQUISITION, *_EXCITATION)}
"""Every effect with a name, in the order of the stages."""
