"""A block that is kept as the device gave it and read back at the rate that was asked for."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.bench.resampling import half_width, resample


@dataclass(frozen=True, slots=True)
class RecutRule:
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
        half, count = half_width(from_hz, to_hz), round(block_s * to_hz)
        return cls(from_hz, to_hz, half, 2 * half + ceil(count * from_hz / to_hz) + 1, count)

    @classmethod
    def read(cls, facts: Mapping[str, float | str]) -> "RecutRule | None":
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
