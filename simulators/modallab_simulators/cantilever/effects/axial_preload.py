"""A beam under an axial force."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s = altered.structure
    return replace(altered, structure=replace(s, preload_n=effect.parameters["force"]))


PART = EffectPart(
    name="axial_preload",
    rank=520,
    change=_change,
    several=False,
    outside=EffectKind(
        "axial_preload",
        "structure",
        (Parameter("force", "N", 1e-3, 5e3, signed=True),),
        "all",
        "the beam is pulled by force along its axis, or pushed where it is negative",
    ),
)
