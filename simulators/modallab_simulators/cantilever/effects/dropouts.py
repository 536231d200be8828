"""A row that loses samples."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, lost_share={**c.lost_share, row_of(effect): effect.parameters["share"]}))


PART = EffectPart(
    name="dropouts",
    rank=560,
    change=_change,
    several=False,
    outside=EffectKind(
        "dropouts",
        "acquisition",
        (Parameter("share", "", 1e-5, 0.3),),
        "channel",
        "a share of one channel's samples is lost and reads 0",
    ),
    limits={"share": (0.0, 1.0)},
    drawn=Drawn(slope=0.5),
)
