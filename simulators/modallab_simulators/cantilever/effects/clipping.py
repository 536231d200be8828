"""A row that is cut at a level."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.block import Block
from modallab.core.effects import Effect, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, ClippedRow, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    numbers = effect.parameters
    clip = ClippedRow(row_of(effect), numbers["fraction_of_peak"], numbers.get("peak_v"))
    c = altered.chain
    return replace(altered, chain=replace(c, clips=(*c.clips, clip)))


def _on_campaign(blocks: Sequence[Block], effect: Effect) -> list[Block]:
    """A row cut at a share of the most it reaches in the whole campaign."""
    row = row_of(effect)
    most = max(float(np.abs(b.samples[row].astype(np.float64)).max()) for b in blocks)
    level = round(effect.parameters["fraction_of_peak"] * most)
    cut: list[Block] = []
    for block in blocks:
        samples = block.samples.copy()
        np.clip(samples[row], -level, level, out=samples[row])
        cut.append(replace(block, samples=samples))
    return cut


PART = EffectPart(
    name="clipping",
    rank=270,
    change=_change,
    several=False,
    # What the channel would reach, if the bench shall not work it out from its hardest hit.
    options=("peak_v",),
    limits={"fraction_of_peak": (0.0, 1.0)},
    on_campaign=_on_campaign,
    drawn=Drawn(slope=-1.0),
)
