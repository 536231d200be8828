"""A force at one place that follows the beam's own motion there."""

from dataclasses import replace
from math import pi

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Absorber, Attachment
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart
from modallab_simulators.cantilever.modes import Damper


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s, law, x = altered.structure, effect.parameters, x_of(effect, rig)
    if "k" in law or "m" in law:
        own = Attachment(x, mass=law.get("m", 0.0), stiffness=law.get("k", 0.0))
        s = replace(s, attachments=(*s.attachments, own))
    if "c" in law:
        s = replace(s, dampers=(*s.dampers, Damper(x, law["c"])))
    if "hung_m" in law:
        hung = Absorber(x, law["hung_m"], law["hung_m"] * (2 * pi * law["hung_hz"]) ** 2)
        s = replace(s, absorbers=(*s.absorbers, hung))
    return replace(altered, structure=s)


PART = EffectPart(
    name="point_law",
    rank=600,
    change=_change,
    several=True,
    outside=EffectKind(
        "point_law",
        "structure",
        (Parameter("k", "N/m", 1e-3, 1e4, "EI/L^3", signed=True),),
        "x",
        "a force at x that follows the motion there",
    ),
)
