"""A root that shifts."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch

SOFT = 0.01
"""Stiffness of the root in EI / L^3, below which nothing stands any more."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s = twin.structure
    compliance = s.bending_stiffness / s.length_m**3 / effect.parameters["k_trans"]
    return replace(twin, structure=replace(s, root_translation=compliance))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    stiff = beam.bending_stiffness_n_m2 / beam.length_m**3
    return (
        FreeNumber("k_trans", "log", spread_logarithmically(50 * stiff, 5e4 * stiff, 7), low=SOFT * stiff, power=-1.0),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "clamp_translation",
        "structure",
        (Parameter("k_trans", "N/m", 20.0, 2e6, "EI/L^3", spoken="translational stiffness"),),
        "root",
        "the root shifts across the beam against a spring k_trans, its rotation held",
    ),
    rank=20,
    spoken="clamp translation",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(rank=20, slots=_slots),
    experiment="Put an accelerometer on the clamp itself: a translating root moves the clamp, a rotating root does "
    "not.",
)
