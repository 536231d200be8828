"""A channel on which there is nothing but the last step of its converter."""

import numpy as np

from modallab.core.arrays import Real
from modallab.signals.faults.runs import Fault

MOST_STEPS = 4
"""Between the smallest and the largest value: the noise of a converter without a signal."""


def dead(row: Real, channel: str, steps: Real) -> tuple[Fault, ...]:
    """Whether a channel (n,) stays within a few steps of its converter; `steps` (n,) as of `steps_of`."""
    span, step = float(np.ptp(row)), float(steps.max())
    # A little more, as sums of steps are rounded.
    if span > (MOST_STEPS + 0.01) * step:
        return ()
    return (Fault(channel, f"moves by no more than {span / step:.0f} steps of its converter", 0.0, row.size),)
