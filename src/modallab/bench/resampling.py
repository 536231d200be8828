"""A block that is kept as the device gave it and read back at the rate that was asked for.

Each new sample is a sum of the old ones about its place, weighted by a Kaiser-windowed sinc (Oppenheim and Schafer,
Discrete-Time Signal Processing, 7.5) evaluated at exactly that place, so that any ratio of rates is as good as another.
Up to 0.4 of the lower rate the error is below 1e-6; what is above 0.6 of it is gone. A block needs `half_width` old
samples more at both ends.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, pi
from typing import Self

import numpy as np
from numpy.typing import NDArray

PASS = 0.4
"""Part of the lower rate up to which the signal is kept."""

_STOP_DB = 135.0
_BETA = 0.1102 * (_STOP_DB - 8.7)


def samples_on_either_side(from_hz: float, to_hz: float) -> int:
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
    half = samples_on_either_side(from_hz, to_hz)
    place = lead + np.arange(count) * (from_hz / to_hz)
    base = np.floor(place).astype(np.int64)
    if base[0] - half + 1 < 0 or base[-1] + half >= values.shape[1]:
        raise ValueError(f"{values.shape[1]} samples are too few for {count} resampled ones with {half} on either side")
    around = np.arange(1 - half, half + 1)
    weights = _weights(around - (place - base)[:, None], half, min(1.0, to_hz / from_hz))
    index = base[:, None] + around
    return np.stack([np.einsum("mj,mj->m", row[index], weights) for row in values.astype(np.float64)])


def _weights(offset: NDArray[np.float64], half: int, cutoff: float) -> NDArray[np.float64]:
    window = np.i0(_BETA * np.sqrt(np.maximum(0.0, 1 - (offset / half) ** 2)))
    weights = np.sinc(cutoff * offset) * window
    return weights / weights.sum(axis=1, keepdims=True)


@dataclass(frozen=True, slots=True)
class ResamplingRule:
    """How a block is recut.

    Attributes:
        from_hz: the device's rate.
        to_hz: the rate that was asked for.
        lead: samples kept before the block.
        native: samples kept in all.
        count: samples of the block at the new rate.
    """

    from_hz: float
    to_hz: float
    lead: int
    native: int
    count: int

    @classmethod
    def of(cls, from_hz: float, to_hz: float, block_s: float) -> Self:
        """For blocks of `block_s`, as near as whole samples at the new rate come to it."""
        half, count = samples_on_either_side(from_hz, to_hz), round(block_s * to_hz)
        return cls(from_hz, to_hz, half, 2 * half + ceil(count * from_hz / to_hz) + 1, count)

    @classmethod
    def read(cls, facts: Mapping[str, float | str]) -> "ResamplingRule | None":
        """From what is written beside a block; None if it was not to be recut."""
        if "recut_to_hz" not in facts:
            return None
        whole = (int(facts["recut_lead"]), int(facts["recut_native"]), int(facts["recut_count"]))
        return cls(float(facts["recut_from_hz"]), float(facts["recut_to_hz"]), *whole)

    def facts(self) -> dict[str, float | str]:
        """What is written beside a block."""
        return {
            "recut_from_hz": self.from_hz,
            "recut_to_hz": self.to_hz,
            "recut_lead": float(self.lead),
            "recut_native": float(self.native),
            "recut_count": float(self.count),
        }

    def apply(self, samples: NDArray[np.generic]) -> NDArray[np.float64]:
        """(channels, count) at the new rate of (channels, native) as kept."""
        return resample(samples, self.from_hz, self.to_hz, self.lead, self.count)
