"""Inputs that pass no slow motion."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart
from modallab_simulators.cantilever.sensor import high_pass


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, filters=(*c.filters, (None, high_pass(effect.parameters["corner_hz"])))))


PART = EffectPart(
    name="ac_coupling",
    rank=250,
    change=_change,
    several=False,
)
