"""The mains on every row."""

from dataclasses import replace

import numpy as np

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, hum=(effect.parameters["volts"], effect.parameters["hz"])))


def _hz(rng: np.random.Generator) -> float:
    return float(rng.choice([50.0, 60.0]))


PART = EffectPart(
    name="mains_hum",
    rank=330,
    change=_change,
    several=False,
    drawn=Drawn(hz=_hz),
)
