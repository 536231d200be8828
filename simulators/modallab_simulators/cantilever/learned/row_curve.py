"""A static curve between what one channel would read and what it reads."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from modallab.core.arrays import Real
from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _distorted(law: Mapping[str, float], volts: Real) -> Real:
    if "tanh_v" in law:
        return law["tanh_v"] * np.tanh(volts / law["tanh_v"])
    if "knee_v" in law:
        power = law.get("power", 2.0)
        return volts / (1 + np.abs(volts / law["knee_v"]) ** power) ** (1 / power)
    return volts + law.get("square", 0.0) * volts**2 + law.get("cubic", 0.0) * volts**3


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(
        altered, chain=replace(c, curves={**c.curves, row_of(effect): partial(_distorted, dict(effect.parameters))})
    )


def _check(effect: Effect, rig: Rig) -> list[str]:
    if any(name.endswith("_share") for name in effect.parameters):
        return ["row_curve: a level relative to each record's own peak cannot be simulated sample by sample"]
    return []


PART = EffectPart(
    name="row_curve",
    rank=630,
    change=_change,
    several=False,
    check=_check,
    outside=EffectKind(
        "row_curve", "sensor", (Parameter("tanh_v", "V", 0.05, 1e4),), "channel", "one channel reads a curve"
    ),
)
