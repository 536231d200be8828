"""A damper from the beam to ground."""

from dataclasses import replace

from modallab.core.effects import Effect, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart
from modallab_simulators.cantilever.modes import Damper


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s = altered.structure
    return replace(
        altered, structure=replace(s, dampers=(*s.dampers, Damper(x_of(effect, rig), effect.parameters["c"])))
    )


PART = EffectPart(
    name="local_damper",
    rank=110,
    change=_change,
    several=True,
    drawn=Drawn(places=(0.3, 1.0)),
)
