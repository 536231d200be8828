"""A root that turns: a spring behind its own."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s = altered.structure
    return replace(altered, structure=replace(s, root_nm_rad=(*s.root_nm_rad, effect.parameters["k_rot"])))


PART = EffectPart(
    name="clamp_rotation",
    rank=10,
    change=_change,
    several=False,
    drawn=Drawn(slope=-1.0),
)
