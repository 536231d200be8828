"""A spring that stiffens with the deflection."""

from dataclasses import replace
from functools import partial

from modallab.core.effects import Effect, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart
from modallab_simulators.cantilever.feedback.elements import PointElement


def _element(x_m: float, k3: float, beam: CantileverBeam) -> PointElement:
    return PointElement(x_m, 0, "cubic", (k3,))


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    element = partial(_element, x_of(effect, rig), effect.parameters["k3"])
    s = altered.structure
    return replace(altered, structure=replace(s, elements=(*s.elements, element)))


PART = EffectPart(
    name="cubic_spring",
    rank=50,
    change=_change,
    several=True,
    drawn=Drawn(places=(0.5, 1.0)),
)
