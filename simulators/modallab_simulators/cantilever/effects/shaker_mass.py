"""A mass between beam and force transducer, in the sine test."""

from dataclasses import replace

from modallab.core.effects import Effect, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Attachment
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    mass = Attachment(x_of(effect, rig), mass=effect.parameters["mass"])
    s = altered.structure
    return replace(altered, structure=replace(s, at_shaker=(*s.at_shaker, mass)))


PART = EffectPart(
    name="shaker_mass",
    rank=410,
    change=_change,
    several=False,
)
