"""A row with more noise than the converter has."""

from dataclasses import replace

from modallab.core.effects import Effect, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, noise={**c.noise, row_of(effect): effect.parameters["factor"]}))


PART = EffectPart(
    name="noisy_channel",
    rank=230,
    change=_change,
    several=False,
)
