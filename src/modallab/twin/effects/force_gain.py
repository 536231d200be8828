"""A force transducer with another sensitivity than stated."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import FORCE_SHARE, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, RivalEffect, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, chain=replace(twin.chain, force_gain=effect.parameters["gain"]))


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["gain"] - 1, FORCE_SHARE * rig.tolerance.sensitivity)


MODEL = EffectModel(
    kind=EffectKind(
        "force_gain",
        "sensor",
        (Parameter("gain", "", 1e-3, 2.0, signed=True, none=1.0),),
        "force",
        "the force channel reads gain times the true force; the range is that of |gain - 1|",
    ),
    rank=90,
    spoken="force gain",
    change=_change,
    moves_poles=False,
    once=True,
    search=EffectSearch(
        rank=120,
        slots=lambda _: (
            FreeNumber("gain", "log", (0.5, 0.7, 0.85, 0.95, 1.05, 1.15, 1.3, 1.6), low=0.1, high=5.0, none=1.0),
        ),
        tolerance=ReplacedTolerance(deviations=_own_deviations, replaces="sensitivity"),
    ),
    experiment="Calibrate the force transducer with a known mass on a string.",
    rivals=(
        RivalEffect("clock_error", "Calibrate the force transducer with a known mass on a string.", rank=70),
        RivalEffect("", plan="Strike a free known mass: that calibrates the hammer apart from the beam's density."),
    ),
)
