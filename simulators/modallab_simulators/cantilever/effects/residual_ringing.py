"""A beam that still rings when it is struck."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    return replace(altered, excitation=replace(altered.excitation, ringing=effect.parameters["fraction"]))


PART = EffectPart(
    name="residual_ringing",
    rank=440,
    change=_change,
    several=False,
)
