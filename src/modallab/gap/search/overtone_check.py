"""Whether the law of an effect makes the overtones that were measured: no fit has seen them.

The fits see the lines about a sine's own. At twice to five times its frequency a linear beam answers nothing, so what
stands there is the law's own (Worden and Tomlinson, Nonlinearity in Structural Dynamics, 2001, ch. 3).
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import Prepared
from modallab.gap.conditioning.reduce import Reduced
from modallab.gap.model.fit import Fit
from modallab.gap.model.own_numbers import twin_of
from modallab.gap.model.predicted_records import predict_record
from modallab.signals.signals import to_signals
from modallab.twin.bench import Twin

Array = NDArray[np.float64]

ORDERS = (2, 3, 4, 5)
CLEAR = 8.0
"""Times its neighbours from which a line is an overtone that can be compared."""
BAND = 0.4
"""Share of the rate up to which the chain passes what the beam does."""
BLOCKS = 16
"""Blocks that are predicted, at most."""


def overtones_closed(fit: Fit, prepared: Prepared, unseen: Reduced) -> float:
    """Share of the clear overtones that a fit predicts on records it has not seen; 1 where none is clear.

    1 less the mean over the overtones of the squares left, each as a share of its own squares over all channels and at
    most 1.
    """
    if unseen.sines is None:
        return 1.0
    twin, rig, blocks = twin_of(fit, unseen), unseen.rig, {b.name: b for b in prepared.blocks}
    names = [p.name for p in unseen.sines.pieces][:BLOCKS]
    left = [share for name in names for share in _left(twin, rig, blocks[name], unseen)]
    return 1.0 - float(np.mean(left)) if left else 1.0


def _left(twin: Twin, rig: Rig, block: Block, unseen: Reduced) -> list[float]:
    assert unseen.sines is not None
    ratio, sigma = unseen.sines.ratio, unseen.sines.ratio_sigma
    said = predict_record(twin, rig, block, unseen.last_order, ratio if abs(ratio - 1) > 5 * sigma else 1.0)
    seen, said = (np.fft.rfft(y, axis=1) for y in (to_signals(block, rig).responses, said))
    line = round((block.frequency_hz or 0.0) * block.n_samples / block.rate_hz)
    found: list[float] = []
    for at in (k * line for k in ORDERS):
        if line < 3 or at + 3 > BAND * block.n_samples:
            continue
        around = np.max(np.abs(seen[:, [at - 2, at - 1, at + 1, at + 2]]), axis=1)
        clear = np.abs(seen[:, at]) > CLEAR * around
        if np.any(clear):
            off = np.sum(np.abs(seen[clear, at] - said[clear, at]) ** 2)
            found.append(float(min(off / np.sum(np.abs(seen[clear, at]) ** 2), 1.0)))
    return found
