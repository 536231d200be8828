"""Samples at full scale: an overload, and no measurement."""

from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.signals.checks import check_block
from modallab.signals.conversion import Conversion


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
