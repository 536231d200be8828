"""An accelerometer that is turned over."""

from dataclasses import replace

from modallab.core.effects import Effect, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    row = row_of(effect)
    c = altered.chain
    return replace(altered, chain=replace(c, gain={**c.gain, row: c.gain.get(row, 1.0) * effect.parameters["sign"]}))


PART = EffectPart(
    name="polarity",
    rank=210,
    change=_change,
    several=False,
    limits={"sign": (-1.0, -1.0)},
)
