"""A root that shifts."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s = altered.structure
    return replace(altered, structure=replace(s, root_n_m=effect.parameters["k_trans"]))


PART = EffectPart(
    name="clamp_translation",
    rank=20,
    change=_change,
    several=False,
    drawn=Drawn(slope=-1.0),
)
