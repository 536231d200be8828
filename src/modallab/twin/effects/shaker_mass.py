"""A mass between beam and force transducer."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, RivalEffect, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, shaker_mass_kg=effect.parameters["mass"])


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    return (FreeNumber("mass", "log", spread_logarithmically(1e-3 * beam.mass_kg, 0.5 * beam.mass_kg, 14)),)


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["mass"], rig.tolerance.shaker_mass_kg)


MODEL = EffectModel(
    kind=EffectKind(
        "shaker_mass",
        "excitation",
        (Parameter("mass", "kg", 1e-5, 2.0, "m"),),
        "shaker",
        "a mass at the shaker point on the beam's side of the force transducer",
        tests=("sine",),
    ),
    rank=30,
    spoken="shaker mass",
    change=_change,
    moves_poles=False,
    once=True,
    search=EffectSearch(
        rank=90,
        slots=_slots,
        needs="shaker",
        tolerance=ReplacedTolerance(replaces="shaker_mass_kg", deviations=_own_deviations),
    ),
    experiment="Repeat the hits with the shaker fastened: an attached mass then lowers the frequencies.",
    rivals=(
        RivalEffect("stinger_moment", "Repeat the sines with the shaker at another point.", rank=50),
        RivalEffect("added_mass", "Remove the shaker and repeat the hits.", rank=60),
    ),
)
