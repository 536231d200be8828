"""The accelerometers' own mass."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Attachment
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    each, points = effect.parameters["mass_each"], [c.point for c in rig.responses if c.point is not None]
    masses = [Attachment(rig.x_of(point), mass=each) for point in points]
    s = altered.structure
    return replace(altered, structure=replace(s, attachments=(*s.attachments, *masses)))


PART = EffectPart(
    name="sensor_mass",
    rank=90,
    change=_change,
    several=False,
)
