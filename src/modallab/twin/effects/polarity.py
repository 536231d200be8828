"""An accelerometer that is turned over."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.effect_model import EffectModel, EffectSearch


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    gain = dict(twin.chain.gain)
    gain[row_of(effect)] = gain.get(row_of(effect), 1.0) * effect.parameters["sign"]
    return replace(twin, chain=replace(twin.chain, gain=gain))


MODEL = EffectModel(
    kind=EffectKind(
        "polarity",
        "sensor",
        (Parameter("sign", "", 1.0, 1.0, signed=True),),
        "channel",
        "one channel is turned over",
    ),
    rank=20,
    spoken="polarity",
    change=_change,
    moves_poles=False,
    once=False,
    search=EffectSearch(rank=220, slots=lambda _: (), fixed=(("sign", -1.0),)),
    experiment="Push the beam by hand at the suspect accelerometer: a turned sensor has the opposite sign of its "
    "neighbour.",
)
