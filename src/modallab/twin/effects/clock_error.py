"""A converter with another rate than stated."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, values_of_both_signs
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, number_in_deviations

QUARTZ = 5e-5
"""Deviation of one ordinary clock from another: two quartzes are up to 100 millionths apart."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, clock=effect.parameters["relative"])


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["relative"], QUARTZ if rig.tolerance.of_assembly else 0.0)


MODEL = EffectModel(
    kind=EffectKind(
        "clock_error",
        "acquisition",
        (Parameter("relative", "", 1e-6, 0.1, signed=True, spoken="relative error of the rate"),),
        "all",
        "the converter's true rate is (1 + relative) times the stated one",
    ),
    rank=30,
    spoken="clock error",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(
        rank=150,
        slots=lambda _: (
            FreeNumber("relative", "plain", values_of_both_signs(1e-4, 0.04, 7), 0.01, low=-0.1, high=0.1),
        ),
        needs="sine",
        tolerance=ReplacedTolerance(is_clock=True, deviations=_own_deviations),
    ),
    experiment="Record a tone of known frequency: its frequency is off by the error of the clock.",
)
