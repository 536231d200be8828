"""A root with free play."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, SteppedLaw
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw

WITHIN = 1e-2
"""Least stiffness of the root in EI / L within the play: a beam must hang on something."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s, numbers = twin.structure, effect.parameters
    unit = s.bending_stiffness / s.length_m
    root = s.root_rotation + unit / max(numbers.get("k_within", 0.0), WITHIN * unit)
    element = NonlinearElement(NonlinearLaw.PLAY, 0.0, (numbers["k_contact"], numbers["gap"]))
    return replace(twin, structure=replace(s, root_rotation=root), element=element)


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    unit = beam.bending_stiffness_n_m2 / beam.length_m
    return (
        FreeNumber("k_contact", "log", spread_logarithmically(2 * unit, 400 * unit, 7), power=-1.0),
        FreeNumber("gap", "log", spread_logarithmically(3e-6, 6e-4, 9)),
        # What still holds the root within the play; no joint lets a beam hang on nothing.
        FreeNumber("k_within", "log", (8 * unit,), low=WITHIN * unit, high=400 * unit, power=0.0),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "clearance",
        "structure",
        (
            Parameter("k_contact", "N m/rad", 1.0, 500.0, "EI/L", spoken="stiffness in contact"),
            Parameter("gap", "rad", 1e-6, 1e-2, spoken="free play"),
        ),
        "root",
        "a free play at the root: beyond the gap a spring k_contact takes over",
        linear=False,
    ),
    rank=40,
    spoken="clearance",
    change=_change,
    moves_poles=True,
    once=True,
    # How a contact begins is a convention.
    search=EffectSearch(rank=40, slots=_slots, inexact=0.05, law=SteppedLaw(behind="k_contact")),
    experiment="Repeat the sines at a third level: a play stiffens the root with the level, friction softens it.",
)
