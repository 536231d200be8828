"""Samples at the converter's full scale: an overload, as on any bench, and no measurement."""

import numpy as np

from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.signals.checks import check_block


def overloaded(block: Block, rig: Rig) -> tuple[str, ...]:
    """Names of the channels that reach the full scale in this block.

    For whole counts full scale is the type's own end; for volts it is the channel's or the converter's range. What came
    in engineering units from elsewhere has no full scale that is known. What the device itself reported counts as well.

    Raises:
        DataError: samples that are no records, parts that do not fit, or other channels than the rig's.
    """
    check_block(block, rig)
    peaks = np.max(np.abs(block.samples.astype(np.float64)), axis=1)
    reported = block.overload or (False,) * len(block.channels)
    return tuple(name for i, name in enumerate(block.channels) if reported[i] or peaks[i] >= _full_scale(block, rig, i))


def _full_scale(block: Block, rig: Rig, index: int) -> float:
    limits = [np.inf]
    if block.units[index] == "V":
        ranges = [rig.channels[index].range_v, rig.converter.range_v if rig.converter else None]
        bits = rig.converter.bits if rig.converter else 16
        limits += [r / abs(float(block.scale[index])) * (1 - 2.0 ** (1 - bits)) for r in ranges if r is not None]
    if block.samples.dtype.kind == "i":
        limits.append(2.0 ** (8 * block.samples.dtype.itemsize - 1) - 1)
    return min(limits) * (1 - 1e-12)
