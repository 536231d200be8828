"""An accelerometer that rocks on its mount."""

from dataclasses import replace

from modallab.core.effects import Effect, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart
from modallab_simulators.cantilever.sensor import loose_mount


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    own = loose_mount(effect.parameters["hz"], effect.parameters["zeta"])
    c = altered.chain
    return replace(altered, chain=replace(c, filters=(*c.filters, (row_of(effect), own))))


PART = EffectPart(
    name="loose_mount",
    rank=260,
    change=_change,
    several=False,
    limits={"zeta": (0.0, 0.9)},
    drawn=Drawn(slope=-2.0),
)
