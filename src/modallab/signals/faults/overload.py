"""Channels at full scale, as their range, their converter or the device itself says."""

import numpy as np

from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.signals.checks import check_block
from modallab.signals.conversion import Conversion
from modallab.signals.faults.runs import Fault


def overloads(block: Block, rig: Rig) -> tuple[Fault, ...]:
    """The channels of a block that reach full scale, and how often; raises as `overloaded_channels`."""
    return tuple(_overload(block, name) for name in overloaded_channels(block, rig))


def _overload(block: Block, channel: str) -> Fault:
    row = np.abs(block.samples[block.channels.index(channel)].astype(np.float64))
    there = np.flatnonzero(row == row.max())
    return Fault(channel, "reaches the converter's full scale", float(there[0] / block.rate_hz), there.size)


def overloaded_channels(block: Block, rig: Rig) -> tuple[str, ...]:
    """Names of the channels that reach full scale in this block.

    For whole counts full scale is the type's own end; for volts it is the channel's or the converter's range. What came
    in engineering units from elsewhere has no full scale that is known. What the device itself reported counts as well.

    Raises:
        DataError: samples that are no records, parts that do not fit, or other channels than the rig's.
    """
    check_block(block, rig)
    found = Conversion.of_block(block, rig).overload(block.samples)
    reported = block.overload or (False,) * len(block.channels)
    return tuple(name for name, over, flag in zip(block.channels, found, reported, strict=True) if over or flag)
