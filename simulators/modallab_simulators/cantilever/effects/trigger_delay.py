"""A force that is stamped late."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, delay_s=effect.parameters["seconds"]))


PART = EffectPart(
    name="trigger_delay",
    rank=310,
    change=_change,
    several=False,
    limits={"seconds": (0.0, 0.02)},
)
