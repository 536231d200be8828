"""A beam that bends more at one place, as at a crack that stays open."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, along_beam
from modallab.twin.effect_model import EffectModel, EffectSearch, RivalEffect

WIDTH = 0.04
"""Half width of the loss over L."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s = twin.structure
    loss = (x_of(effect, rig), effect.parameters["EI_loss"], WIDTH * s.length_m)
    return replace(twin, structure=replace(s, losses=(*s.losses, loss)))


MODEL = EffectModel(
    kind=EffectKind(
        "stiffness_loss",
        "structure",
        (Parameter("EI_loss", "", 1e-4, 0.95, spoken="loss of bending stiffness"),),
        "x",
        "EI falls by the share EI_loss at x and by less about it, as exp(-((x - x0) / (0.04 L))^2) (a crack)",
        at_points=Parameter("k", "N/m", 1e-4, 0.95, "EI/L^3", spoken="stiffness"),
    ),
    rank=80,
    spoken="stiffness loss",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(
        rank=50,
        slots=lambda _: (FreeNumber("EI_loss", "share", (0.05, 0.2, 0.45, 0.7, 0.85), high=0.97), along_beam()),
        # How a crack's loss spreads along the beam is a convention.
        inexact=0.03,
    ),
    experiment="Strike on both sides of the place: the shapes bend most at a crack.",
    rivals=(
        RivalEffect("clamp_rotation", "Strike close to the clamp: the slope there shows a rotating root.", rank=30),
    ),
)
