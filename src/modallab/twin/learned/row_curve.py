"""A static curve between what one channel would read and what it reads."""

from collections.abc import Mapping

import numpy as np

from modallab.core.arrays import Real
from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange


def apply_curve(volts: Real, law: Mapping[str, float]) -> Real:
    """(n,) V that a channel reads of what it would read in one record, by its law.

    tanh_v: v tanh(u / v). knee_v, power: u / (1 + |u / v|^power)^(1 / power). With tanh_share or knee_share v is that
    share of the record's largest |u|. square, cubic: u + square u^2 + cubic u^3.
    """
    peak = float(np.max(np.abs(volts), initial=0.0)) or 1.0
    if "tanh_v" in law or "tanh_share" in law:
        level = law["tanh_v"] if "tanh_v" in law else law["tanh_share"] * peak
        return level * np.tanh(volts / level)
    if "knee_v" in law or "knee_share" in law:
        level = law["knee_v"] if "knee_v" in law else law["knee_share"] * peak
        power = law.get("power", 2.0)
        return volts / (1 + np.abs(volts / level) ** power) ** (1 / power)
    return volts + law.get("square", 0.0) * volts**2 + law.get("cubic", 0.0) * volts**3


MODEL = EffectModel(
    kind=EffectKind(
        "row_curve",
        "sensor",
        (
            Parameter("tanh_v", "V", 0.05, 1e4, spoken="saturation level"),
            Parameter("tanh_share", "", 0.1, 100.0, spoken="saturation level over the peak"),
            Parameter("knee_v", "V", 0.05, 1e4, spoken="saturation level"),
            Parameter("knee_share", "", 0.1, 100.0, spoken="saturation level over the peak"),
            Parameter("power", "", 0.5, 20.0, spoken="power of the knee"),
            Parameter("square", "1/V", 1e-6, 1.0, signed=True, spoken="square term"),
            Parameter("cubic", "1/V^2", 1e-6, 1.0, signed=True, spoken="cubic term"),
        ),
        "channel",
        "one channel reads a curve of what it would read, u in V: v tanh(u / v) with v = tanh_v, or "
        "u / (1 + |u / v|^power)^(1 / power) with v = knee_v, v a share of each record's own peak where it is given "
        "so, or u + square u^2 + cubic u^3",
        linear=False,
    ),
    rank=40,
    spoken="a curve between sensor and record",
    change=NoChange.NO_FORCE_PREDICTS_IT,
    moves_poles=False,
    once=False,
    search=None,
    experiment="Repeat the hits softer: at small readings a curve is nearly linear.",
)
