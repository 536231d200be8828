"""Hits beside the point."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, values_of_both_signs
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, hit_shift_m=effect.parameters["dx"])


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    length = beam.length_m
    return (FreeNumber("dx", "plain", values_of_both_signs(2e-3 * length, 0.06 * length, 4), 0.01),)


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["dx"], rig.tolerance.hit_position_m)


MODEL = EffectModel(
    kind=EffectKind(
        "hit_position",
        "excitation",
        (Parameter("dx", "m", 1e-5, 0.2, "L", signed=True, spoken="offset"),),
        "hit",
        "every hit lands dx farther from the clamp than its stated point",
        tests=("impact",),
    ),
    rank=10,
    spoken="hit position",
    change=_change,
    moves_poles=False,
    once=True,
    search=EffectSearch(
        rank=160, slots=_slots, needs="impact", tolerance=ReplacedTolerance(deviations=_own_deviations)
    ),
    experiment="Mark the points on the beam and repeat the hits there: sines are not affected.",
)
