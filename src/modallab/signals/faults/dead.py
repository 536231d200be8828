"""A channel on which there is one value, or nothing but the last step of its converter."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Real
from modallab.signals.faults.runs import Fault

MOST_STEPS = 4
"""Between the smallest and the largest value: the noise of a converter without a signal."""
LIVING_LEVELS = 4
"""A living channel that takes no more values than this is at the converter's last count."""


def constant(rows: Real, channels: Sequence[str], forces: Sequence[str]) -> tuple[Fault, ...]:
    """Channels of one value, of rows (channels, n).

    In a record of so little motion that another channel moves by a few counts, a light sensor may stand still; what
    drives may not.
    """
    still = np.ptp(rows, axis=1) == 0
    little = not still.all() and min(np.unique(row).size for row in rows[~still]) <= LIVING_LEVELS
    return tuple(
        Fault(channels[i], f"dead, all values are {rows[i, 0] + 0:g}", 0.0, rows.shape[1])
        for i in map(int, np.flatnonzero(still))
        if channels[i] in forces or not little
    )


def dead(row: Real, channel: str, steps: Real) -> tuple[Fault, ...]:
    """Whether a channel (n,) stays within a few steps of its converter; `steps` (n,) as of `steps_of`."""
    span, step = float(np.ptp(row)), float(steps.max())
    # A little more, as sums of steps are rounded.
    if not span or span > (MOST_STEPS + 0.01) * step:
        return ()
    return (Fault(channel, f"moves by no more than {span / step:.0f} steps of its converter", 0.0, row.size),)
