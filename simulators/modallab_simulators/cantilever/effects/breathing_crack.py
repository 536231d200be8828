"""A crack that opens and closes."""

from dataclasses import replace
from functools import partial

from modallab.core.effects import Effect, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart
from modallab_simulators.cantilever.feedback.elements import CrackElement


def _element(x_m: float, loss: float, beam: CantileverBeam) -> CrackElement:
    return CrackElement(x_m, loss, beam.bending_stiffness_n_m2)


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    element = partial(_element, x_of(effect, rig), effect.parameters["EI_loss_open"])
    s = altered.structure
    return replace(altered, structure=replace(s, elements=(*s.elements, element)))


PART = EffectPart(
    name="breathing_crack",
    rank=60,
    change=_change,
    several=True,
    limits={"EI_loss_open": (0.0, 0.99)},
    drawn=Drawn(places=(0.08, 0.3)),
)
