"""An accelerometer at another place than stated."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, values_of_both_signs
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    shift = {**twin.chain.shift, row_of(effect): effect.parameters["dx"]}
    return replace(twin, chain=replace(twin.chain, shift=shift))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    length = beam.length_m
    return (FreeNumber("dx", "plain", values_of_both_signs(2e-3 * length, 0.08 * length, 4), 0.01),)


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["dx"], rig.tolerance.position_m)


MODEL = EffectModel(
    kind=EffectKind(
        "position_error",
        "sensor",
        (Parameter("dx", "m", 1e-5, 0.2, "L", signed=True, spoken="offset"),),
        "channel",
        "one accelerometer sits dx farther from the clamp than the rig file says",
    ),
    rank=50,
    spoken="position error",
    change=_change,
    moves_poles=False,
    once=False,
    search=EffectSearch(
        rank=230, slots=_slots, tolerance=ReplacedTolerance(replaces="position_m", deviations=_own_deviations)
    ),
    experiment="Exchange the accelerometer with its neighbour: a wrong place stays, a wrong gain moves with the "
    "sensor.",
)
