"""Two accelerometers on exchanged rows."""

from dataclasses import replace

from modallab.core.effect import TwoChannels
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    assert isinstance(effect.place, TwoChannels)
    c = altered.chain
    return replace(altered, chain=replace(c, exchanged=(*c.exchanged, effect.place.channel)))


PART = EffectPart(
    name="swap",
    rank=220,
    change=_change,
    several=False,
)
