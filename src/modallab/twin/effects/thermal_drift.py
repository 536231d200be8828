"""A beam that changes its stiffness over the campaign."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, values_of_both_signs
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, RivalEffect, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, ei_drift=twin.ei_drift + effect.parameters["EI_drift"])


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["EI_drift"], rig.tolerance.stiffness_drift)


MODEL = EffectModel(
    kind=EffectKind(
        "thermal_drift",
        "structure",
        (Parameter("EI_drift", "", 1e-5, 0.3, signed=True, spoken="change of bending stiffness"),),
        "none",
        "EI has changed by the share EI_drift at the last record, about evenly over the order of time",
    ),
    rank=130,
    spoken="thermal drift",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(
        rank=80,
        slots=lambda _: (
            FreeNumber("EI_drift", "plain", values_of_both_signs(1e-3, 0.12, 10), 0.01, low=-0.4, high=0.4),
        ),
        # A bench warms neither evenly nor by a curve that its records show between them.
        inexact=0.02,
        tolerance=ReplacedTolerance(
            absorbed_by="Young's modulus", replaces="stiffness_drift", deviations=_own_deviations
        ),
    ),
    experiment="Repeat the first hits at the end: only a drift gives another beam than at the beginning.",
    rivals=(RivalEffect("clamp_rotation", "Repeat the first hits at the end.", rank=90),),
)
