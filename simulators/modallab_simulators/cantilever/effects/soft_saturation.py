"""A row that saturates softly."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, knee_v={**c.knee_v, row_of(effect): effect.parameters["volts"]}))


PART = EffectPart(
    name="soft_saturation",
    rank=550,
    change=_change,
    several=False,
    outside=EffectKind(
        "soft_saturation",
        "sensor",
        (Parameter("volts", "V", 0.05, 1e4),),
        "channel",
        "one channel reads v / sqrt(1 + (v / volts)^2)",
        linear=False,
    ),
    drawn=Drawn(slope=-2.0),
)
