"""How an output comes to 0 V when it is stopped: from the value it has, along half a cosine."""

from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

FALL_S = 0.010
"""The shortest fall."""

MOST_PER_S = 50.0
"""Of the level: 5 % a ms. Half a cosine of 10 ms from the full level would change by up to 15.7 % a ms."""


def ramp_down_s(from_v: float, level_v: float) -> float:
    """How long the fall takes: FALL_S, or longer so that no part of it is steeper than MOST_PER_S of the level.

    Args:
        from_v: where it begins.
        level_v: amplitude of what was played, above 0.
    """
    return max(FALL_S, pi / 2 * abs(from_v) / (MOST_PER_S * level_v))


def ramp_down_volts(times_s: NDArray[np.float64], from_v: float, level_v: float) -> NDArray[np.float64]:
    """The fall in V at times since it began: `from_v` before, exactly 0 after."""
    part = np.clip(times_s / ramp_down_s(from_v, level_v), 0, 1)
    return np.where(part < 1, from_v * (1 + np.cos(pi * part)) / 2, 0.0)


def ramp_down_samples(from_v: float, level_v: float, rate_hz: float) -> NDArray[np.float64]:
    """The fall as (n,) volts at an output's rate, n at least 2; the last sample is exactly 0."""
    count = max(2, ceil(ramp_down_s(from_v, level_v) * rate_hz) + 1)
    return ramp_down_volts(np.arange(count) / rate_hz, from_v, level_v)
