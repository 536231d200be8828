"""A force all along the beam that follows its shape or its deflection."""

from dataclasses import replace

from modallab.core.arrays import gauss_legendre
from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Attachment
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart

PLACES = 12
"""Springs that stand for an even bedding: Gauss points, exact for the product of two low modes."""


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    assert rig.beam is not None
    s, law, length = altered.structure, effect.parameters, rig.beam.length_m
    s = replace(s, preload_n=s.preload_n + law.get("tension", 0.0))
    if "bedding" in law:
        at, weights = gauss_legendre(PLACES)
        places, shares = ((at + 1) / 2 * length).tolist(), (weights / 2 * length).tolist()
        springs = [Attachment(x, stiffness=law["bedding"] * w) for x, w in zip(places, shares, strict=True)]
        s = replace(s, attachments=(*s.attachments, *springs))
    return replace(altered, structure=s)


PART = EffectPart(
    name="beam_law",
    rank=610,
    change=_change,
    several=True,
    outside=EffectKind(
        "beam_law",
        "structure",
        (Parameter("tension", "N", 1e-3, 1e6, signed=True),),
        "all",
        "a force all along the beam that follows its shape",
    ),
)
