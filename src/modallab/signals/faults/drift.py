"""A zero that drifts: a sensor that warms up, a charge amplifier that leaks, a foot on the cable."""

import numpy as np

from modallab.core.arrays import Real
from modallab.signals.faults.runs import Fault

LOWEST_LINE = 3
"""Of a record in which modes are looked for, by default: below it stand what drifts and the rest of the mean."""
ORDER = 2 * LOWEST_LINE
"""Of the polynomial that follows a drift: it turns twice in a period."""
SHARE = 0.5
"""Of a record's variance, from which on it is the drift that is recorded."""


def drift(row: Real, rate_hz: float, channel: str) -> tuple[Fault, ...]:
    """Whether an acceleration (n,) is mostly drift: no structure on a bench gains speed for a whole record."""
    about = row - row.mean()
    power = float(about @ about)
    if power == 0:
        return ()
    slow = np.polynomial.Legendre.fit(np.arange(row.size), about, ORDER)(np.arange(row.size))
    if float(slow @ slow) < SHARE * power:
        return ()
    return (Fault(channel, f"its zero drifts by {np.ptp(slow):.3g}, more than it moves", 0.0, row.size),)
