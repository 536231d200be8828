"""Hits beside the point."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    return replace(altered, excitation=replace(altered.excitation, hit_shift_m=effect.parameters["dx"]))


PART = EffectPart(
    name="hit_position",
    rank=400,
    change=_change,
    several=False,
)
