"""A stinger that resists bending."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, stinger_k_rot=effect.parameters["k_rot"])


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    ei, length = beam.bending_stiffness_n_m2, beam.length_m
    return (FreeNumber("k_rot", "log", spread_logarithmically(0.02 * ei / length, 100 * ei / length, 12)),)


def _own_deviations(effect: Effect, rig: Rig) -> float:
    assert rig.beam is not None
    unit = rig.beam.bending_stiffness_n_m2 / rig.beam.length_m
    return number_in_deviations(effect.parameters["k_rot"] / unit, rig.tolerance.stinger_rotation)


MODEL = EffectModel(
    kind=EffectKind(
        "stinger_moment",
        "excitation",
        (Parameter("k_rot", "N m/rad", 1e-3, 1e3, "EI/L", spoken="rotational stiffness"),),
        "shaker",
        "the stinger holds the rotation of the shaker point with a spring k_rot",
        tests=("sine",),
    ),
    rank=20,
    spoken="stinger moment",
    change=_change,
    moves_poles=False,
    once=True,
    search=EffectSearch(
        rank=100,
        slots=_slots,
        needs="shaker",
        tolerance=ReplacedTolerance(replaces="stinger_rotation", deviations=_own_deviations),
    ),
    experiment="Repeat the sines with the shaker at another point, or with a thinner stinger.",
)
