"""A root that turns."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, number_in_deviations
from modallab.twin.structure import ROOT, root_of_rig_file

SOFT = 0.01
"""Stiffness of the root in EI / L, below which nothing stands any more."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s = twin.structure
    # What is soft beside the root that the rig file speaks of: one spring behind the other.
    added = s.bending_stiffness / s.length_m / effect.parameters["k_rot"]
    return replace(twin, structure=replace(s, root_rotation=s.root_rotation + added))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    ei, length = beam.bending_stiffness_n_m2, beam.length_m
    starts = spread_logarithmically(4 * ei / length, 4e3 * ei / length, 7)
    return (FreeNumber("k_rot", "log", starts, low=SOFT * ei / length, power=-1.0),)


def _own_deviations(effect: Effect, rig: Rig) -> float:
    assert rig.beam is not None
    turned = rig.beam.bending_stiffness_n_m2 / rig.beam.length_m / effect.parameters["k_rot"]
    # Where the rig file states a spring, what it states is "about" so much.
    stated = root_of_rig_file(rig.beam)
    return number_in_deviations(turned, ROOT * stated if stated else rig.tolerance.clamp_compliance)


MODEL = EffectModel(
    kind=EffectKind(
        "clamp_rotation",
        "structure",
        (Parameter("k_rot", "N m/rad", 2.0, 2e5, "EI/L", spoken="rotational stiffness"),),
        "root",
        "the root turns against a spring k_rot",
    ),
    rank=10,
    spoken="clamp rotation",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(
        rank=10, slots=_slots, tolerance=ReplacedTolerance(replaces="clamp_compliance", deviations=_own_deviations)
    ),
    experiment="Strike close to the clamp: the slope there shows a rotating root, not a crack or a translation.",
)
