"""Rows that are sampled one after the other."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, RivalEffect


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, chain=replace(twin.chain, skew_s=effect.parameters["seconds_per_channel"]))


MODEL = EffectModel(
    kind=EffectKind(
        "channel_skew",
        "acquisition",
        (Parameter("seconds_per_channel", "s", 1e-9, 2e-4, spoken="delay per channel"),),
        "all",
        "row k of the converter is sampled k seconds_per_channel later than row 0, the force",
    ),
    rank=10,
    spoken="channel skew",
    change=_change,
    moves_poles=False,
    once=True,
    search=EffectSearch(
        rank=130,
        slots=lambda _: (
            FreeNumber("seconds_per_channel", "plain", spread_logarithmically(1e-7, 2e-4, 7), 1e-5, low=0.0, high=3e-4),
        ),
        # Between samples a bench or a simulation interpolates, none of them exactly.
        inexact=0.02,
    ),
    experiment="Exchange the first and the last row of the converter and repeat: a skew stays with the row.",
    rivals=(RivalEffect("trigger_delay", "Exchange the first and the last row of the converter and repeat.", rank=80),),
)
