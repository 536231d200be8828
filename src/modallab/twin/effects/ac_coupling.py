"""Inputs that pass no slow motion."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, chain=replace(twin.chain, corner_hz=effect.parameters["corner_hz"]))


MODEL = EffectModel(
    kind=EffectKind(
        "ac_coupling",
        "sensor",
        (Parameter("corner_hz", "Hz", 1e-3, 20.0, spoken="corner frequency"),),
        "all",
        "every accelerometer passes a first-order high-pass, -3 dB at corner_hz",
    ),
    rank=60,
    spoken="ac coupling",
    change=_change,
    moves_poles=False,
    once=True,
    search=EffectSearch(
        rank=110,
        slots=lambda _: (FreeNumber("corner_hz", "log", spread_logarithmically(0.01, 8.0, 7), low=1e-4, high=200.0),),
    ),
    experiment="Switch the inputs to DC and repeat the sines at low frequencies: only a high-pass changes the phase.",
)
