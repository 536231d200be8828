"""An accelerometer with another sensitivity than stated."""

from dataclasses import replace

from modallab.core.effects import Effect, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    row = row_of(effect)
    c = altered.chain
    return replace(altered, chain=replace(c, gain={**c.gain, row: c.gain.get(row, 1.0) * effect.parameters["gain"]}))


PART = EffectPart(
    name="gain_error",
    rank=200,
    change=_change,
    several=False,
)
