"""Drag of the air."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, SteppedLaw
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw

STATIONS = 5.0
"""Places at which a lumped drag acts."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    per_length = effect.parameters["c2_total"] / twin.structure.length_m
    return replace(
        twin, element=NonlinearElement(NonlinearLaw.DRAG, 0.0, (per_length, effect.parameters.get("stations", 0.0)))
    )


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    return (FreeNumber("c2_total", "log", spread_logarithmically(0.3, 100.0, 12)),)


MODEL = EffectModel(
    kind=EffectKind(
        "air_drag",
        "structure",
        (Parameter("c2_total", "N s^2/m^2", 1e-2, 1e3, spoken="coefficient of quadratic drag"),),
        "all",
        "a drag c2_total/L |v| v per length along the beam",
        linear=False,
    ),
    rank=120,
    spoken="air drag",
    change=_change,
    moves_poles=True,
    once=True,
    # How a drag spreads along the beam is a convention: evenly, or lumped at a few stations as simulators do.
    search=EffectSearch(
        rank=100,
        slots=_slots,
        forms=((), (("stations", STATIONS),)),
        inexact=0.05,
        law=SteppedLaw(smooth=True),
    ),
    experiment="Repeat the sines at a third level: drag damps in proportion to the amplitude, the frequencies stay.",
)
