"""The lines about the overtones of a few sines, beside the lines about the sines themselves.

A linear beam within its tolerances may follow each sine to a thousandth and still lack all of its overtones: a small
crack is nearly a small loss of stiffness. There the overtones alone say which law it is, and how large.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.gap.conditioning.overtones import ORDERS, Harmonic
from modallab.gap.conditioning.reduce import LINES
from modallab.gap.conditioning.rows import Reduced, Rows

FEWEST = 4
"""Channels on which an overtone must be clear to count."""


def with_overtones(data: Reduced, overtones: Sequence[Harmonic]) -> Reduced:
    """The sines with the lines about those of their overtones that are clear; an order's lines follow the one's before.

    Args:
        data: the sines, each with the lines about itself.
        overtones: of the records; those of others are passed over.
    """
    if data.sines is None:
        return data
    blocks, channels = len(data.sines.pieces), len(data.channels)
    clear = {(o.record, o.order): o for o in overtones if np.count_nonzero(o.is_clear) >= FEWEST}
    orders = [k for k in ORDERS if any((p.name, k) in clear for p in data.sines.pieces)]
    groups = 1 + len(orders)
    rows, source = data.sines.rows, data.sines.source
    lines = np.tile(source.lines[:, None], (1, groups, 1))
    y = np.zeros((channels, blocks, groups, LINES), dtype=np.complex128)
    sigma = np.full(y.shape, np.inf)
    y[:, :, 0] = rows.y.reshape(channels, blocks, LINES)
    sigma[:, :, 0] = rows.sigma.reshape(channels, blocks, LINES)
    for j, piece in enumerate(data.sines.pieces):
        for at, order in enumerate(orders, 1):
            o = clear.get((piece.name, order))
            if o is None:
                continue
            lines[j, at] = o.lines
            y[:, j, at] = o.spectrum / source.force[j]
            sigma[:, j, at] = np.where(o.is_clear, o.beside, np.inf)[:, None] / abs(source.force[j])
    count = blocks * groups * LINES
    common, direction = np.zeros(count), np.zeros((channels, count), dtype=np.complex128)
    kept = Rows(y.reshape(channels, -1), sigma.reshape(channels, -1), common, direction)
    return replace(data, sines=replace(data.sines, source=replace(source, lines=lines.reshape(blocks, -1)), rows=kept))
