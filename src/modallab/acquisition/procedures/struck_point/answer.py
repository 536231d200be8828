"""What the structure has answered to one hit, ready to be compared with other hits and with what was expected."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError
from modallab.signals.conversion import Conversion
from modallab.signals.hit import find_hit, windowed_force
from modallab.signals.transform import previous_quick_length, spectrum

Samples = NDArray[Any]

EXCITED = 0.1
"""A line counts as excited where the force has this part of its largest line."""
USABLE = 0.4
"""Lines up to this part of the rate; above it the anti-alias filter falls."""


@dataclass(frozen=True, eq=False, slots=True)
class Answer:
    """One hit.

    Attributes:
        force_n: (n,) zero but for the hit.
        force: (lines,) its spectrum; line k is k / block duration.
        motion: by place in the rig, the (lines,) spectrum of each channel asked for, SI units, less what was there
            before the hit.
        rate_hz: of both.
        band_hz: up to which the hit excites.
    """

    force_n: Real
    force: Complex128
    motion: dict[int, Complex128]
    rate_hz: float
    band_hz: float

    def of(self, channels: Iterable[int]) -> Complex128:
        """(channels, lines) spectra."""
        return np.stack([self.motion[channel] for channel in channels])

    def frf(self, channels: Iterable[int], up_to_hz: float) -> Complex128:
        """(channels, lines) of the block's lines above 0 up to a frequency; the block's end is in it."""
        count = int(up_to_hz * self.force_n.size / self.rate_hz) + 1
        force = self.force[1:count]
        floor = 1e-3 * np.abs(force).max()
        force = np.where(np.abs(force) < floor, floor, force)
        return self.of(channels)[:, 1:count] / force


def answer_of(
    samples: Samples, conversion: Conversion, rate_hz: float, before: int, channels: Iterable[int], up_to_hz: float
) -> Answer | None:
    """The answer in a block.

    Args:
        samples: (rig's channels, n) as delivered.
        conversion: to SI units.
        rate_hz: of the samples.
        before: index of the trigger.
        channels: whose answer is wanted.
        up_to_hz: at least so far.

    Returns:
        Lines up to that frequency or the hit's band, whichever is higher; None if no hit stands out of the noise.
    """
    # A block less its last per cent says as much; its own number of samples may take the transform four times as long.
    samples = samples[:, : previous_quick_length(samples.shape[1])]
    force_n = conversion.force_n(samples)
    try:
        force_n = windowed_force(force_n, find_hit(force_n))
    except DataError:
        return None
    force, line_hz = spectrum(force_n), rate_hz / force_n.size
    band_hz = _band_hz(np.abs(force), line_hz, rate_hz)
    count = min(force.size, int(1.1 * max(up_to_hz, band_hz) / line_hz) + 8)
    motion: dict[int, Complex128] = {}
    for channel in channels:
        row = samples[channel]
        moves = (row - row[: max(1, before - 1)].mean(dtype=np.float64)).astype(np.float32)
        # Single precision is half the time, and right to a part in a million of the largest line.
        motion[channel] = spectrum(moves)[:count].astype(np.complex128) * conversion.si_per_count[channel]
    return Answer(force_n, force[:count], motion, rate_hz, band_hz)


def _band_hz(spectrum: Real, line_hz: float, rate_hz: float) -> float:
    weak = np.flatnonzero(spectrum < EXCITED * spectrum.max())
    last = weak[0] if weak.size else spectrum.size
    return min(float(last) * line_hz, USABLE * rate_hz)
