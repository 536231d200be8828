"""Preamplifiers and converter: from what a channel sees to counts."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.schema.rig import Converter, Rig
from modallab.schema.units import Test, si_factor


@dataclass(frozen=True, eq=False, slots=True)
class Chain:
    """The chain of all channels, in rig order.

    Attributes:
        volts_per_si: (channels,) sensitivity in V per SI unit, signed by the sensor's direction.
        volts_per_count: (channels,)
        noise_rms_v: white noise before the converter.
        low: smallest count.
        high: largest count.
        dtype: of the counts.
    """

    volts_per_si: NDArray[np.float64]
    volts_per_count: NDArray[np.float64]
    noise_rms_v: float
    low: int
    high: int
    dtype: np.dtype[np.generic]

    @classmethod
    def of(cls, rig: Rig, test: Test) -> Self:
        """The chain of a rig in a test.

        Raises:
            RigError: a channel has no sensitivity for this test.
        """
        converter = rig.converter or Converter()
        volts = [
            c.sensitivity(test) / si_factor(c.quantity, c.unit, c.name) * _turned(rig, c.direction)
            for c in rig.channels
        ]
        full = 2 ** (converter.bits - 1)
        return cls(
            np.array(volts),
            np.array([(c.range_v or converter.range_v) / full for c in rig.channels]),
            converter.noise_rms_v,
            -full,
            full - 1,
            np.dtype(np.int16 if converter.bits <= 16 else np.int32),
        )

    def convert(self, seen: NDArray[np.float64], noise: NDArray[np.float32]) -> NDArray[np.generic]:
        """Counts of what the channels see in SI units, both (channels, n); noise is of unit variance."""
        counts = seen * (self.volts_per_si / self.volts_per_count)[:, None]
        counts += noise * (self.noise_rms_v / self.volts_per_count).astype(np.float32)[:, None]
        np.rint(counts, out=counts)
        np.clip(counts, self.low, self.high, out=counts)
        return counts.astype(self.dtype)

    def overload(self, samples: NDArray[np.generic]) -> NDArray[np.bool_]:
        """Which channels stand at a rail anywhere in `samples`, (channels,)."""
        return np.any((samples == self.high) | (samples == self.low), axis=1)


def _turned(rig: Rig, direction: str) -> float:
    # The beam bends in the plane of the drive only: a sensor across it sees no motion.
    if direction[1] != rig.drive_direction[1]:
        return 0.0
    return 1.0 if direction[0] == rig.drive_direction[0] else -1.0
