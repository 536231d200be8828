"""A root that sticks and slips: a slider beside a spring."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from math import exp, log

import numpy as np

from modallab.core.effects import Effect
from modallab.core.rig import Beam, Rig
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart, Ties
from modallab_simulators.cantilever.feedback.elements import PointElement


def _element(numbers: Mapping[str, float], beam: CantileverBeam) -> PointElement:
    # A spring in series with a joint of two stiffnesses makes it another such joint: each stiffness in series with the
    # spring, and the change from one to the other at the same moment.
    slip, stick, root = numbers["k_slip"], numbers["k_stick"], beam.root_stiffness_nm_rad
    series = 1 / root - 1 / stick
    slider = root - 1 / (1 / slip + series)
    moment = numbers["moment_limit"] * stick / (stick - slip)
    return PointElement(0.0, 1, "friction", (slider, moment * slider / root))


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    element = partial(_element, effect.parameters)
    s = altered.structure
    return replace(
        altered,
        structure=replace(
            s, root_nm_rad=(*s.root_nm_rad, effect.parameters["k_stick"]), elements=(*s.elements, element)
        ),
    )


def _check(effect: Effect, rig: Rig) -> list[str]:
    slip, stick = effect.parameters["k_slip"], effect.parameters["k_stick"]
    return [f"clamp_friction: k_stick is {stick:g}; allowed: above k_slip, {slip:g}"] if stick <= slip else []


def _ties(rng: np.random.Generator, beam: Beam, moment: float) -> Ties:
    ratio = rng.uniform(3.0, 8.0)
    limit = exp(rng.uniform(log(0.02), log(0.2))) * moment * (1 - 1 / ratio)
    return {"k_stick": (ratio, 1.0), "moment_limit": (limit, 0.0)}


PART = EffectPart(
    name="clamp_friction",
    rank=30,
    change=_change,
    several=False,
    check=_check,
    joint=True,
    drawn=Drawn(slope=-1.0, ties=_ties),
)
