"""A crack that opens and closes."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import Slot, along_beam
from modallab.twin.effect_model import EffectModel, Search, x_of
from modallab.twin.effects.stiffness_loss import WIDTH
from modallab.twin.nonlinear.element import Element, Law


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    numbers = (effect.parameters["EI_loss_open"], WIDTH * twin.structure.length_m)
    return replace(twin, element=Element(Law.CRACK, x_of(effect, rig), numbers))


def _slots(beam: Beam) -> tuple[Slot, ...]:
    return (Slot("EI_loss_open", "share", (0.4, 0.8), high=0.97), along_beam())


MODEL = EffectModel(
    kind=EffectKind(
        "breathing_crack",
        "structure",
        (Parameter("EI_loss_open", "", 1e-4, 0.95),),
        "x",
        "a stiffness loss about x while the curvature is positive, none while it is negative",
        linear=False,
    ),
    rank=90,
    spoken="breathing crack",
    change=_change,
    moves_poles=True,
    once=False,
    search=Search(rank=90, slots=_slots, looked_for=False),
    experiment="Look for even overtones in the sine responses: a crack that breathes makes them at every level.",
)
