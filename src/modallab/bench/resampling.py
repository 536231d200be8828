"""From the rate a device gives to the rate that was asked for, block by block.

Each new sample is a sum of the old ones about its place, weighted by a Kaiser-windowed sinc (Oppenheim and Schafer,
Discrete-Time Signal Processing, 7.5) evaluated at exactly that place, so that any ratio of rates is as good as another.
Up to 0.4 of the lower rate the error is below 1e-6; what is above 0.6 of it is gone. A block needs `half_width` old
samples more at both ends.
"""

from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

PASS = 0.4
"""Part of the lower rate up to which the signal is kept."""

_STOP_DB = 135.0
_BETA = 0.1102 * (_STOP_DB - 8.7)


def half_width(from_hz: float, to_hz: float) -> int:
    """Old samples that are needed on either side of a new one."""
    transition = (1 - 2 * PASS) * min(from_hz, to_hz) / from_hz
    return ceil((_STOP_DB - 7.95) / (2.285 * 2 * pi * transition) / 2) + 1


def resample(values: NDArray[np.generic], from_hz: float, to_hz: float, lead: int, count: int) -> NDArray[np.float64]:
    """New samples of a block.

    Args:
        values: (channels, n) old samples; n at least lead + (count - 1) from_hz / to_hz + half_width + 1.
        from_hz: their rate.
        to_hz: the requested rate.
        lead: index of the old sample that stands where the first new one shall.
        count: new samples.

    Returns:
        (channels, count).

    Raises:
        ValueError: the block has too few samples at an end.
    """
    half = half_width(from_hz, to_hz)
    place = lead + np.arange(count) * (from_hz / to_hz)
    base = np.floor(place).astype(np.int64)
    if base[0] - half + 1 < 0 or base[-1] + half >= values.shape[1]:
        raise ValueError(f"{values.shape[1]} samples are too few for {count} new ones with {half} on either side")
    around = np.arange(1 - half, half + 1)
    weights = _weights(around - (place - base)[:, None], half, min(1.0, to_hz / from_hz))
    index = base[:, None] + around
    return np.stack([np.einsum("mj,mj->m", row[index], weights) for row in values.astype(np.float64)])


def _weights(offset: NDArray[np.float64], half: int, cutoff: float) -> NDArray[np.float64]:
    window = np.i0(_BETA * np.sqrt(np.maximum(0.0, 1 - (offset / half) ** 2)))
    weights = np.sinc(cutoff * offset) * window
    return weights / weights.sum(axis=1, keepdims=True)
