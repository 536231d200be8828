"""A mass on the beam."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, along_beam, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, RivalEffect, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s = twin.structure
    return replace(twin, structure=replace(s, masses=(*s.masses, (x_of(effect, rig), effect.parameters["mass"]))))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    return (FreeNumber("mass", "log", spread_logarithmically(1e-3 * beam.mass_kg, 0.4 * beam.mass_kg, 5)), along_beam())


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["mass"], rig.tolerance.sensor_mass_kg)


MODEL = EffectModel(
    kind=EffectKind(
        "added_mass",
        "structure",
        (Parameter("mass", "kg", 1e-5, 1.0, "m"),),
        "x",
        "a point mass at x",
    ),
    rank=60,
    spoken="added mass",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(rank=40, slots=_slots, tolerance=ReplacedTolerance(deviations=_own_deviations)),
    experiment="Screw a known mass to the free end and repeat the hits: its own shift gives the scale.",
    rivals=(
        RivalEffect(
            "sensor_mass",
            "Take all accelerometers but one off and repeat the hits: frequencies that rise alike indicate the "
            "sensors.",
            rank=10,
            plan="Repeat the hits with one accelerometer only: this separates the sensors' mass from another.",
        ),
        RivalEffect("clamp_rotation", "Screw a known mass to the free end and repeat the hits.", rank=20),
    ),
)
