"""What a beam under a sine does at multiples of its frequency, where a linear one does nothing.

A sine and its multiples are fitted together by least squares, so that the frequency need not lie on a line of the DFT
(IEEE Std 1057, extended to harmonics).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.signals.signals import to_signals

ORDERS = (2, 3, 4, 5)
CLEAR = 8.0
"""Times what stands beside it from which an overtone is clear."""
BAND = 0.4
"""Share of the rate up to which the chain passes what the beam does."""
LOWEST = 3
"""Periods of the sine in a record below which its multiples lie too close together to be resolved."""
FITTED = 7
"""Multiples that are fitted together."""


@dataclass(frozen=True, eq=False, slots=True)
class Harmonic:
    """One multiple of a sine's frequency in one record.

    Attributes:
        record: its name.
        order: which multiple.
        hz: its frequency.
        y: (channels,) complex amplitude of each accelerometer, SI units.
        beside: (channels,) the largest amplitude within two lines of it.
        lines: (5,) DFT lines about it.
        spectrum: (channels, 5) the record's DFT there, as amplitudes.
    """

    record: str
    order: int
    hz: float
    y: Complex
    beside: Real
    lines: NDArray[np.int64]
    spectrum: Complex

    @property
    def is_clear(self) -> NDArray[np.bool_]:
        """(channels,) on which it stands out of its neighbourhood."""
        return np.abs(self.y) > CLEAR * self.beside


def harmonics_of_sines(blocks: Sequence[Block], rig: Rig, ratio: float = 1.0) -> list[Harmonic]:
    """The multiples of each sine in the band of the chain, clear or not.

    Args:
        blocks: records; those that are no sines are passed over.
        rig: that of the records.
        ratio: the frequency of the sines in the records over what the generator was set to.
    """
    found: list[Harmonic] = []
    for b in blocks:
        if b.test == "sine" and b.frequency_hz:
            found += harmonics_in_record(b.name, to_signals(b, rig).responses, b.rate_hz, b.frequency_hz * ratio)
    return found


def harmonics_in_record(name: str, responses: Real, rate_hz: float, frequency_hz: float) -> list[Harmonic]:
    """The multiples of one sine in responses (channels, n)."""
    n = responses.shape[1]
    line = rate_hz / n
    orders = [k for k in ORDERS if k * frequency_hz + 3 * line <= BAND * rate_hz]
    if frequency_hz < LOWEST * line or not orders:
        return []
    at = 2j * np.pi * np.arange(n) / rate_hz
    count = min(FITTED, int(0.5 * rate_hz / frequency_hz))
    waves = np.exp(np.outer(np.arange(1, count + 1) * frequency_hz, at))
    basis = np.concatenate([np.ones((1, n)), waves.real, -waves.imag])
    solution = np.linalg.lstsq(basis.T, responses.T, rcond=None)[0]
    left = responses - solution.T @ basis
    whole = np.fft.rfft(responses, axis=1) * 2 / n
    found: list[Harmonic] = []
    for k in orders:
        around = np.exp(-np.outer(at, k * frequency_hz + line * np.array([-2, -1, 1, 2])))
        beside = np.max(np.abs(left @ around), axis=1) * 2 / n
        lines = round(k * frequency_hz / line) + np.arange(-2, 3)
        y = solution[k] + 1j * solution[count + k]
        found.append(Harmonic(name, k, k * frequency_hz, y, beside, lines, whole[:, lines]))
    return found
