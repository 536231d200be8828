"""Something on the beam with a resonance of its own."""

from dataclasses import replace
from math import pi

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Absorber
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    mass, hz = effect.parameters["mass"], effect.parameters["hz"]
    hung = Absorber(x_of(effect, rig), mass, mass * (2 * pi * hz) ** 2)
    s = altered.structure
    return replace(altered, structure=replace(s, absorbers=(*s.absorbers, hung)))


PART = EffectPart(
    name="support_resonance",
    rank=510,
    change=_change,
    several=True,
    outside=EffectKind(
        "support_resonance",
        "structure",
        (Parameter("mass", "kg", 1e-5, 1.0, "m"), Parameter("hz", "Hz", 5.0, 200.0)),
        "x",
        "a mass on a spring at x, with a resonance of its own at hz",
    ),
    drawn=Drawn(places=(0.3, 1.0)),
)
