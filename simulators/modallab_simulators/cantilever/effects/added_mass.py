"""A mass on the beam."""

from dataclasses import replace

from modallab.core.effects import Effect, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Attachment
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    mass = Attachment(x_of(effect, rig), mass=effect.parameters["mass"])
    s = altered.structure
    return replace(altered, structure=replace(s, attachments=(*s.attachments, mass)))


PART = EffectPart(
    name="added_mass",
    rank=70,
    change=_change,
    several=True,
    drawn=Drawn(places=(0.3, 1.0)),
)
