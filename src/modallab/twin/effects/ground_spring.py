"""A spring from the beam to ground."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, along_beam, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s = twin.structure
    return replace(twin, structure=replace(s, springs=(*s.springs, (x_of(effect, rig), effect.parameters["k"]))))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    ei, length = beam.bending_stiffness_n_m2, beam.length_m
    return (FreeNumber("k", "log", spread_logarithmically(0.01 * ei / length**3, 30 * ei / length**3, 9)), along_beam())


MODEL = EffectModel(
    kind=EffectKind(
        "ground_spring",
        "structure",
        (Parameter("k", "N/m", 1e-4, 100.0, "EI/L^3", spoken="stiffness"),),
        "x",
        "a spring to ground at x (a cable)",
    ),
    rank=100,
    spoken="ground spring",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(rank=60, slots=_slots),
    experiment="Unfasten the cables one by one and repeat the hits: the first frequency falls with the spring removed.",
)
