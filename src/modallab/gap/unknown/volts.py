"""What the twin says a channel reads, in V, and records freed of what an operator on one channel has made of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.design.prediction import clock_of
from modallab.gap.model.forward import predict_record
from modallab.signals.alignment import lags_s
from modallab.signals.conversion import volts_per_si
from modallab.twin.bench import Twin


@dataclass(frozen=True, eq=False, slots=True)
class ChannelOperator:
    """One channel of all records.

    Attributes:
        row: its number.
        read: record -> (n,) V as recorded.
        counts: record -> (n,) as the converter gave them.
        expected: record -> (n,) V as the twin predicts them.
    """

    row: int
    read: Mapping[str, Real]
    counts: Mapping[str, Real]
    expected: Mapping[str, Real]


def channel_of(prepared: PreparedCampaign, twin: Twin, row: int) -> ChannelOperator:
    """One channel of all records, beside what the twin predicts of it."""
    rig, blocks = prepared.campaign.rig, prepared.blocks
    at = [c.index for c in rig.responses].index(row)
    twin = replace(twin, chain=twin.chain.as_delivered(rig, lags_s(rig)))
    last = float(max(1, *(b.order for b in prepared.campaign.blocks)))
    ratio = clock_of(prepared.campaign, blocks)
    expected = {
        b.name: predict_record(twin, rig, b, last, ratio)[at] * float(volts_per_si(rig, b.test)[row]) for b in blocks
    }
    read = {b.name: (b.samples[row] * b.scale[row]).astype(np.float64) for b in blocks}
    raw = {b.name: b for b in prepared.campaign.blocks}
    counts = {b.name: np.asarray(raw[b.name].samples[row], dtype=np.float64) for b in blocks}
    return ChannelOperator(row, read, counts, expected)


def without_operator(blocks: Sequence[Block], channel: ChannelOperator, made: Mapping[str, Real]) -> tuple[Block, ...]:
    """Records with one channel as it would read without an operator, to first order in what the twin does not know.

    Args:
        blocks: the records.
        channel: the channel.
        made: record -> (n,) V that the operator makes of what the twin predicts; the residual then is what is read
            less this.
    """
    return tuple(_with_correction(b, channel.row, channel.expected[b.name] - made[b.name]) for b in blocks)


def _with_correction(block: Block, row: int, more: Real) -> Block:
    volts = (block.samples * block.scale[:, None]).astype(np.float64)
    volts[row] += more
    return replace(block, samples=volts, scale=np.ones(len(volts)))
