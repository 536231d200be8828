"""Whether the law of an effect makes the overtones that were measured: no fit has seen them.

The fits see the lines about a sine's own. At twice to five times its frequency a linear beam answers nothing, so what
stands there is the law's own (Worden and Tomlinson, Nonlinearity in Structural Dynamics, 2001, ch. 3).
"""

import numpy as np

from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.gap.conditioning.overtones import harmonics_in_record
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.reduce import sine_clock
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit
from modallab.gap.model.forward import predict_record
from modallab.gap.model.twin_of_fit import twin_of
from modallab.signals.signals import to_signals
from modallab.twin.bench import Twin

BLOCKS = 16
"""Blocks that are predicted, at most."""


def overtones_closed(fit: Fit, prepared: PreparedCampaign, unseen: Reduced) -> float:
    """Share of the clear overtones that a fit predicts on records it has not seen; 1 where none is clear.

    1 less the mean over the overtones of the squares left, each as a share of its own squares over all channels and at
    most 1.
    """
    if unseen.sines is None:
        return 1.0
    twin, rig, blocks = twin_of(fit, unseen), unseen.rig, {b.name: b for b in prepared.blocks}
    names = [p.name for p in unseen.sines.pieces][:BLOCKS]
    left = [share for name in names for share in _residual_shares(twin, rig, blocks[name], unseen)]
    return 1.0 - float(np.mean(left)) if left else 1.0


def _residual_shares(twin: Twin, rig: Rig, block: Block, unseen: Reduced) -> list[float]:
    ratio = sine_clock(unseen)
    hz = (block.frequency_hz or 0.0) * ratio
    seen = harmonics_in_record(block.name, to_signals(block, rig).responses, block.rate_hz, hz)
    if not any(np.any(o.is_clear) for o in seen):
        return []
    said = harmonics_in_record(
        block.name, predict_record(twin, rig, block, unseen.last_order, ratio), block.rate_hz, hz
    )
    found: list[float] = []
    for measured, predicted in zip(seen, said, strict=True):
        clear = measured.is_clear
        if np.any(clear):
            off = np.sum(np.abs(measured.y[clear] - predicted.y[clear]) ** 2)
            found.append(float(min(off / np.sum(np.abs(measured.y[clear]) ** 2), 1.0)))
    return found
