"""A force transducer with another sensitivity than stated."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, force_gain=effect.parameters["gain"]))


PART = EffectPart(
    name="force_gain",
    rank=280,
    change=_change,
    several=False,
)
