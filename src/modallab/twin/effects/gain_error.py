"""An accelerometer with another sensitivity than stated."""

from dataclasses import replace
from math import inf

from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, RivalEffect, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    gain = dict(twin.chain.gain)
    gain[row_of(effect)] = gain.get(row_of(effect), 1.0) * effect.parameters["gain"]
    return replace(twin, chain=replace(twin.chain, gain=gain))


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["gain"] - 1, rig.tolerance.sensitivity)


def _from_polarity(effect: Effect, other: str, rig: Rig) -> float:
    """A turned channel reads as its sensitivity's tolerance lets it, but turned."""
    return (
        number_in_deviations(-effect.parameters["gain"] - 1, rig.tolerance.sensitivity) if other == "polarity" else inf
    )


MODEL = EffectModel(
    kind=EffectKind(
        "gain_error",
        "sensor",
        (Parameter("gain", "", 1e-3, 2.0, signed=True, none=1.0),),
        "channel",
        "one channel reads gain times the true value; the range is that of |gain - 1|",
    ),
    rank=10,
    spoken="gain error",
    change=_change,
    moves_poles=False,
    once=False,
    search=EffectSearch(
        rank=210,
        slots=lambda _: (
            # Turned over as well: a gain of -1 alone is a polarity.
            FreeNumber(
                "gain",
                "plain",
                (-1.6, -0.6, -0.2, 0.2, 0.5, 0.7, 0.85, 0.95, 1.05, 1.15, 1.3, 1.6),
                low=-5.0,
                high=5.0,
                none=1.0,
            ),
        ),
        tolerance=ReplacedTolerance(deviations=_own_deviations, deviations_from=_from_polarity, replaces_gain=True),
    ),
    experiment="Exchange the suspect accelerometer with its neighbour and repeat: a wrong gain moves with the sensor.",
    rivals=(
        RivalEffect("position_error", "Exchange the suspect accelerometer with its neighbour and repeat.", rank=40),
    ),
)
