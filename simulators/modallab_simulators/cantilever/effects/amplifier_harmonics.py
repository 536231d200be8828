"""A power amplifier that adds overtones."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    return replace(altered, excitation=replace(altered.excitation, harmonics=effect.parameters["share"]))


PART = EffectPart(
    name="amplifier_harmonics",
    rank=580,
    change=_change,
    several=False,
    outside=EffectKind(
        "amplifier_harmonics",
        "excitation",
        (Parameter("share", "", 1e-4, 0.5),),
        "shaker",
        "the power amplifier makes v (1 + share v / V + share (v / V)^2) of v, with V = 5 V; the force channel sees it",
        tests=("sine",),
    ),
    limits={"share": (0.0, 1.0)},
    seen_by_force=True,
)
