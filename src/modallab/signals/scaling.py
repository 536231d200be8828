"""Step A: from what the device delivered to SI units, mean removed."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Signals
from modallab.core.errors import DataError
from modallab.core.rig import Channel, Rig
from modallab.core.units import is_voltage, si_factor
from modallab.signals.ac_coupling import uncoupled
from modallab.signals.alignment import aligned, lags_s
from modallab.signals.checks import check_block, check_rows


def to_signals(block: Block, rig: Rig) -> Signals:
    """Scale a block to SI units; a sensor that looks against the drive direction is turned, one that lags is aligned.

    Args:
        block: as delivered, channels in rig order.
        rig: sensitivities, units and directions.

    Raises:
        DataError: channels other than the rig's, a unit that is not the channel's, a scale of nothing, or samples that
            are no records.
    """
    check_block(block, rig)
    factors = [_factor(c, u, s, block, rig) for c, u, s in zip(rig.channels, block.units, block.scale, strict=True)]
    values: NDArray[np.float64] = block.samples.astype(np.float64) * np.array(factors)[:, None]
    values = aligned(uncoupled(values, block.rate_hz, rig, block.frequency_hz), block.rate_hz, lags_s(rig))
    force = rig.force_channel.index
    return Signals(
        force=values[force],
        responses=np.delete(values, force, axis=0),
        rate_hz=block.rate_hz,
        outputs=tuple(c.name for c in rig.responses),
        block=block,
    )


def _factor(channel: Channel, unit: str, scale: float, block: Block, rig: Rig) -> float:
    where = f"record {block.name}, channel {channel.name}"
    turned = channel.direction[0] != rig.drive_direction[0] and channel.quantity != "force"
    axis_differs = channel.direction[1] != rig.drive_direction[1]
    if axis_differs and channel.quantity != "force":
        raise DataError(
            f"measures along {channel.direction}, the beam is driven along {rig.drive_direction}",
            where=where,
            remedy="leave the channel out, or mend its direction in the rig file",
        )
    sign = -1.0 if turned else 1.0
    if is_voltage(unit) and channel.quantity != "voltage":
        volts = si_factor("voltage", unit, where)
        return sign * scale * volts / channel.sensitivity(block.test) * si_factor(channel.quantity, channel.unit, where)
    return sign * scale * si_factor(channel.quantity, unit, where)


def to_signals_of(blocks: Sequence[Block], rig: Rig) -> list[Signals]:
    """`to_signals` for several blocks, which must share rate and length.

    Raises:
        DataError: the blocks differ in rate or length.
    """
    shapes = {(b.rate_hz, b.n_samples) for b in blocks}
    if len(shapes) > 1:
        listed = ", ".join(f"{n} samples at {rate:g} Hz" for rate, n in sorted(shapes))
        raise DataError(
            f"the blocks of one test differ: {listed}", remedy="identify them apart, each kind in a campaign of its own"
        )
    return [to_signals(b, rig) for b in blocks]


def remove_mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (n,) or (rows, n) with each row's mean taken off: the paper's non-zero mean cancellation.

    Raises:
        DataError: values that are no records.
    """
    check_rows(values)
    return values - values.mean(axis=-1, keepdims=True)
