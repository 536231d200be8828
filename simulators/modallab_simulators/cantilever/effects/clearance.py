"""A root with free play: a spring that takes over beyond a gap."""

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
    # A spring in series with such a joint makes it another: see `clamp_friction`.
    within, gap, root = numbers.get("k_within", 0.0), numbers["gap"], beam.root_stiffness_nm_rad
    series = 1 / root - 1 / (numbers["k_contact"] + within)
    soft = within / (1 + within * series)
    return PointElement(0.0, 1, "play", (root - soft, gap * (1 + within * series)))


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    numbers = effect.parameters
    stiffest, element = numbers["k_contact"] + numbers.get("k_within", 0.0), partial(_element, numbers)
    s = altered.structure
    return replace(
        altered, structure=replace(s, root_nm_rad=(*s.root_nm_rad, stiffest), elements=(*s.elements, element))
    )


def _ties(rng: np.random.Generator, beam: Beam, moment: float) -> Ties:
    play = exp(rng.uniform(log(0.1), log(0.5))) * moment
    within = rng.uniform(6.0, 11.0) * beam.bending_stiffness_n_m2 / beam.length_m
    return {"gap": (play, -1.0), "k_within": (within, 0.0)}


PART = EffectPart(
    name="clearance",
    rank=40,
    change=_change,
    several=False,
    # What still holds the root within the play.
    options=("k_within",),
    joint=True,
    drawn=Drawn(slope=-1.0, ties=_ties),
)
