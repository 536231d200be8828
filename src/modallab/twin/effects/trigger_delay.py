"""A force that is stamped late."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, chain=replace(twin.chain, delay_s=-effect.parameters["seconds"]))


MODEL = EffectModel(
    kind=EffectKind(
        "trigger_delay",
        "acquisition",
        (Parameter("seconds", "s", 1e-8, 5e-3, spoken="delay"),),
        "all",
        "the force is recorded late by seconds: its sample is aligned with a later acceleration",
    ),
    rank=20,
    spoken="trigger delay",
    change=_change,
    moves_poles=False,
    once=True,
    search=EffectSearch(
        rank=140,
        slots=lambda _: (
            FreeNumber("seconds", "plain", spread_logarithmically(1e-6, 4e-3, 9), 1e-4, low=0.0, high=8e-3),
        ),
    ),
    experiment="Feed one signal to the force row and to another: a delay between the two is then visible without "
    "the beam.",
)
