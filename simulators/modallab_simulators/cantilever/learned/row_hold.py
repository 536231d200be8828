"""A channel that loses some of its samples."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c, row = altered.chain, row_of(effect)
    kept = c.holds | {row} if effect.parameters.get("kept") else c.holds
    return replace(altered, chain=replace(c, lost_share={**c.lost_share, row: effect.parameters["share"]}, holds=kept))


PART = EffectPart(
    name="row_hold",
    rank=640,
    change=_change,
    several=False,
    outside=EffectKind(
        "row_hold", "acquisition", (Parameter("share", "", 1e-5, 0.5),), "channel", "one channel loses samples"
    ),
)
