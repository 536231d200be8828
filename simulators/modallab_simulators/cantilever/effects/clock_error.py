"""A converter with another rate than stated."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, clock=effect.parameters["relative"]))


PART = EffectPart(
    name="clock_error",
    rank=320,
    change=_change,
    several=False,
    limits={"relative": (-0.2, 0.2)},
)
