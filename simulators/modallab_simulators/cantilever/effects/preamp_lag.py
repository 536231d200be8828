"""A preamplifier that is slow."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart
from modallab_simulators.cantilever.sensor import low_pass


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(
        altered, chain=replace(c, filters=(*c.filters, (row_of(effect), low_pass(effect.parameters["corner_hz"]))))
    )


PART = EffectPart(
    name="preamp_lag",
    rank=540,
    change=_change,
    several=False,
    outside=EffectKind(
        "preamp_lag",
        "sensor",
        (Parameter("corner_hz", "Hz", 20.0, 1e6),),
        "channel",
        "one accelerometer passes a first-order low-pass, -3 dB at corner_hz",
    ),
    drawn=Drawn(slope=-1.0),
)
