"""Rows that are sampled one after the other."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, skew_s=effect.parameters["seconds_per_channel"]))


PART = EffectPart(
    name="channel_skew",
    rank=300,
    change=_change,
    several=False,
    limits={"seconds_per_channel": (0.0, 0.001)},
)
