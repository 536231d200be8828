"""A pole for every peak of the mobility, however its damping is read."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import Frf
from modallab.frf.estimate import convert_frf
from modallab.identification.start.half_power import HalfPowerPeak, find_peaks, summed_amplitude

LEAST_ZETA = 1e-5
"""A pole read off a peak is given at least this damping: the artificial one is taken off a rough reading."""


def poles_of_peaks(frf: Frf, read: Callable[[Frf, HalfPowerPeak], complex]) -> NDArray[np.complex128]:
    """Poles (peaks,) in rad/s; a damping shift is taken off them again.

    Args:
        frf: any quantity.
        read: the pole of one peak of the mobility.
    """
    mobility = convert_frf(frf, "mobility")
    poles: list[complex] = []
    for peak in find_peaks(mobility.frequency_hz, summed_amplitude(mobility)):
        found = read(mobility, peak) + frf.damping_shift
        poles.append(complex(min(found.real, -LEAST_ZETA * abs(found.imag)), found.imag))
    return np.array(poles, dtype=np.complex128)


def pole_of_mode(frequency_hz: float, zeta: float) -> complex:
    """The pole in rad/s of an undamped frequency and a damping ratio."""
    omega = 2 * np.pi * frequency_hz
    return complex(-zeta * omega, omega * np.sqrt(max(1 - zeta**2, 0.0)))


def half_power_pole(mobility: Frf, peak: HalfPowerPeak) -> complex:
    """The pole that half-power reads; where a flank is missing the width is that of one line."""
    f = mobility.frequency_hz
    spacing = float(f[min(peak.line + 1, f.size - 1)] - f[max(peak.line - 1, 0)]) / 2
    known = np.isfinite(peak.damping_ratio)
    return pole_of_mode(peak.frequency_hz, peak.damping_ratio if known else spacing / (2 * peak.frequency_hz))
