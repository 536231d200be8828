"""What the structure has answered to one hit, ready to be compared with other hits and with what was expected."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.signals.hit import find_hit, windowed_force

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

EXCITED = 0.1
"""A line counts as excited where the force has this part of its largest line."""
USABLE = 0.4
"""Lines up to this part of the rate; above it the anti-alias filter falls."""


@dataclass(frozen=True, eq=False, slots=True)
class Answer:
    """One hit.

    Attributes:
        force_n: (n,) zero but for the hit.
        motion: (channels, n) SI units, less what was there before the hit; the force's row is of no use.
        rate_hz: of both.
        band_hz: up to which the hit excites.
    """

    force_n: Real
    motion: Real
    rate_hz: float
    band_hz: float

    def frf(self, channels: tuple[int, ...], up_to_hz: float) -> Complex:
        """(channels, lines) of the block's lines above 0 up to a frequency; the block's end is in it."""
        count = int(up_to_hz * self.force_n.size / self.rate_hz) + 1
        force = np.fft.rfft(self.force_n)[1:count]
        floor = 1e-3 * np.abs(force).max()
        force = np.where(np.abs(force) < floor, floor, force)
        return np.fft.rfft(self.motion[list(channels)], axis=1)[:, 1:count] / force


def answer_of(samples_si: Real, force_row: int, rate_hz: float, before: int) -> Answer | None:
    """The answer in a block in SI units whose trigger is at index `before`; None if no hit stands out of the noise."""
    force = samples_si[force_row]
    try:
        force = windowed_force(force, find_hit(force))
    except DataError:
        return None
    level = samples_si[:, : max(1, before - 1)].mean(axis=1, keepdims=True)
    return Answer(force, samples_si - level, rate_hz, _band_hz(force, rate_hz))


def _band_hz(force: Real, rate_hz: float) -> float:
    spectrum = np.abs(np.fft.rfft(force))
    weak = np.flatnonzero(spectrum < EXCITED * spectrum.max())
    last = weak[0] if weak.size else spectrum.size
    return min(float(last) * rate_hz / force.size, USABLE * rate_hz)
