"""A force all along the beam that follows its shape or its deflection."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, values_of_both_signs
from modallab.twin.effect_model import EffectModel, EffectSearch

STABLE = 2.2
"""In EI/L^2: a cantilever buckles under pi^2/4 of it."""
BEDDED = 8.0
"""In EI/L^4: a bedding that pushes away leaves it unstable at 12.4, the square of 3.516."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s, law = twin.structure, effect.parameters
    s = replace(s, tension_n=s.tension_n + law.get("tension", 0.0), bedding=s.bedding + law.get("bedding", 0.0))
    return replace(twin, structure=s)


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    axial = beam.bending_stiffness_n_m2 / beam.length_m**2
    per_length = axial / beam.length_m**2
    return (
        FreeNumber(
            "tension", "plain", values_of_both_signs(0.2 * axial, 2 * axial, 3), scale=axial, low=-STABLE * axial
        ),
        FreeNumber(
            "bedding",
            "plain",
            values_of_both_signs(0.5 * per_length, 7 * per_length, 3),
            scale=per_length,
            low=-BEDDED * per_length,
        ),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "beam_law",
        "structure",
        (
            Parameter("tension", "N", 1e-3, 1e6, signed=True, spoken="axial force"),
            Parameter("bedding", "N/m^2", 1e-3, 1e7, signed=True, spoken="stiffness per metre"),
        ),
        "all",
        "a force per length of tension times the curvature less bedding times the displacement; missing numbers are "
        "zero",
    ),
    rank=20,
    spoken="an axial force or an elastic bedding along the beam",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(rank=20, slots=_slots, inexact=0.01),
    experiment="Remove what pulls or presses the beam along its axis, or touches it along its length, and repeat "
    "the hits.",
)
