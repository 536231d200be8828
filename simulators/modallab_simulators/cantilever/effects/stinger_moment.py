"""A stinger that resists bending, in the sine test."""

from dataclasses import replace

from modallab.core.effects import Effect, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Attachment
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    spring = Attachment(x_of(effect, rig), 1, stiffness=effect.parameters["k_rot"])
    s = altered.structure
    return replace(altered, structure=replace(s, at_shaker=(*s.at_shaker, spring)))


PART = EffectPart(
    name="stinger_moment",
    rank=420,
    change=_change,
    several=False,
)
