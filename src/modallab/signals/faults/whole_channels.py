"""Faults of a whole channel: at full scale, dead, or with a zero that drifts."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.signals.checks import check_block
from modallab.signals.conversion import Conversion
from modallab.signals.faults.repeats import SampleFault

MOST_STEPS = 4
"""Between the smallest and the largest value: the noise of a converter without a signal."""
LIVING_LEVELS = 4
"""A living channel that takes no more values than this is at the converter's last count."""
LOWEST_LINE = 3
"""Of a record in which modes are looked for, by default: below it stand what drifts and the rest of the mean."""
_ORDER = 2 * LOWEST_LINE
"""Of the polynomial that follows a drift: it turns twice in a period."""
_SHARE = 0.5
"""Of a record's variance, from which on it is the drift that is recorded."""


def constant_channels(rows: Real, channels: Sequence[str], forces: Sequence[str]) -> tuple[SampleFault, ...]:
    """Channels of one value, of rows (channels, n).

    In a record of so little motion that another channel moves by a few counts, a light sensor may stand still; what
    drives may not.
    """
    still = np.ptp(rows, axis=1) == 0
    little = not still.all() and min(np.unique(row).size for row in rows[~still]) <= LIVING_LEVELS
    return tuple(
        SampleFault(channels[i], f"dead, all values are {rows[i, 0] + 0:g}", 0.0, rows.shape[1])
        for i in map(int, np.flatnonzero(still))
        if channels[i] in forces or not little
    )


def is_dead_channel(row: Real, channel: str, steps: Real) -> tuple[SampleFault, ...]:
    """Whether a channel (n,) stays within a few steps of its converter; `steps` (n,) as of `steps_of`."""
    span, step = float(np.ptp(row)), float(steps.max())
    # A little more, as sums of steps are rounded.
    if not span or span > (MOST_STEPS + 0.01) * step:
        return ()
    return (SampleFault(channel, f"moves by at most {span / step:.0f} steps of its converter", 0.0, row.size),)


def overload_counts(block: Block, rig: Rig) -> tuple[SampleFault, ...]:
    """The channels of a block that reach full scale, and how often; raises as `overloaded_channels`."""
    return tuple(_overload(block, name) for name in overloaded_channels(block, rig))


def _overload(block: Block, channel: str) -> SampleFault:
    row = np.abs(block.samples[block.channels.index(channel)].astype(np.float64))
    there = np.flatnonzero(row == row.max())
    return SampleFault(channel, "reaches the converter's full scale", float(there[0] / block.rate_hz), there.size)


def overloaded_channels(block: Block, rig: Rig) -> tuple[str, ...]:
    """Names of the channels that reach full scale in this block.

    For whole counts full scale is the type's own end; for volts it is the channel's or the converter's range. What came
    in engineering units from elsewhere has no full scale that is known. What the device itself reported counts as well.

    Raises:
        DataError: samples that are no records, parts that do not fit, or other channels than the rig's.
    """
    check_block(block, rig)
    found = Conversion.of_block(block, rig).overloaded_channels(block.samples)
    reported = block.overload or (False,) * len(block.channels)
    return tuple(name for name, over, flag in zip(block.channels, found, reported, strict=True) if over or flag)


def is_zero_drift(row: Real, rate_hz: float, channel: str) -> tuple[SampleFault, ...]:
    """Whether an acceleration (n,) is mostly drift: no structure on a bench gains speed for a whole record.

    A sensor warms up, a charge amplifier leaks, a foot stands on the cable.
    """
    about = row - row.mean()
    power = float(about @ about)
    if power == 0:
        return ()
    slow = np.polynomial.Legendre.fit(np.arange(row.size), about, _ORDER)(np.arange(row.size))
    if float(slow @ slow) < _SHARE * power:
        return ()
    first = _begins_at(row)
    return (
        SampleFault(
            channel,
            f"its zero drifts by {np.ptp(slow):.3g}, more than its vibration",
            first / rate_hz,
            row.size - first,
        ),
    )


def _begins_at(row: Real) -> int:
    """The sample (n,) up to which a mean follows a row and a cubic what comes after, with the least that is left."""
    edges = np.arange(0, row.size - row.size // 8, max(row.size // 128, 1))
    places = np.linspace(-1, 1, row.size)

    def left(first: int) -> float:
        before, after = row[:first], row[first:]
        slow = np.polynomial.Legendre.fit(places[first:], after, 3)(places[first:])
        return float(((before - before.mean()) ** 2).sum() if first else 0.0) + float(((after - slow) ** 2).sum())

    return min(map(int, edges), key=left)
