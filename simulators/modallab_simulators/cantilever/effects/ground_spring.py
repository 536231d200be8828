"""A spring from the beam to ground."""

from dataclasses import replace

from modallab.core.effects import Effect, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Attachment
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    spring = Attachment(x_of(effect, rig), stiffness=effect.parameters["k"])
    s = altered.structure
    return replace(altered, structure=replace(s, attachments=(*s.attachments, spring)))


PART = EffectPart(
    name="ground_spring",
    rank=80,
    change=_change,
    several=True,
    drawn=Drawn(places=(0.3, 1.0)),
)
