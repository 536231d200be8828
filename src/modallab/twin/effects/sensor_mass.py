"""The accelerometers' own mass."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s = twin.structure
    each = tuple((rig.x_of(c.point), effect.parameters["mass_each"]) for c in rig.responses if c.point is not None)
    return replace(twin, structure=replace(s, masses=(*s.masses, *each)))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    return (FreeNumber("mass_each", "log", spread_logarithmically(3e-5 * beam.mass_kg, 0.03 * beam.mass_kg, 7)),)


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["mass_each"], rig.tolerance.sensor_mass_kg)


MODEL = EffectModel(
    kind=EffectKind(
        "sensor_mass",
        "structure",
        (Parameter("mass_each", "kg", 1e-6, 0.1, "m", spoken="mass of each sensor"),),
        "all",
        "a point mass at every accelerometer",
    ),
    rank=70,
    spoken="sensor mass",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(rank=30, slots=_slots, tolerance=ReplacedTolerance(deviations=_own_deviations)),
    experiment="Take all accelerometers but one off and repeat the hits: the frequencies rise if the sensors are "
    "the cause.",
)
