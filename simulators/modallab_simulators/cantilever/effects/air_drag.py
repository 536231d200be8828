"""Drag of the air."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart
from modallab_simulators.cantilever.feedback.elements import Drag


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    assert rig.beam is not None
    s = altered.structure
    return replace(altered, structure=replace(s, drag=Drag(effect.parameters["c2_total"] / rig.beam.length_m)))


PART = EffectPart(
    name="air_drag",
    rank=120,
    change=_change,
    several=False,
)
