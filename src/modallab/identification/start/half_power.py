"""The paper's own reading: peaks of the mobility, damping by the half-power rule."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.axis_checks import check_frequencies
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.frf.estimate import convert_frf
from modallab.signals.peaks import prominent_peaks


@dataclass(frozen=True, slots=True)
class HalfPowerPeak:
    """A local maximum: line index, frequency and the damping ratio half-power reads; NaN where a flank is missing."""

    line: int
    frequency_hz: float
    damping_ratio: float


def summed_amplitude(frf: Frf) -> Real:
    """Root of the sum of squares over outputs and inputs (lines,): peaks of all modes in one curve.

    Raises:
        DataError: no FRF.
    """
    # Output by output: an array of all the squares costs more time than its sum.
    squares = [np.sum(v.real**2 + v.imag**2, axis=0) for v in convert_frf(frf, frf.quantity).values]
    return np.sqrt(np.sum(squares, axis=0))


def find_peaks(frequency_hz: Real, amplitude: Real, prominence_db: float = 6.0) -> list[HalfPowerPeak]:
    """Local maxima that stand out by `prominence_db`, each with its half-power damping.

    Raises:
        DataError: no curve: lengths that differ, frequencies that do not ascend, amplitudes that are none.
    """
    _check_curve(frequency_hz, amplitude)
    level = 20 * np.log10(np.maximum(amplitude, 1e-300))
    found = prominent_peaks(level, prominence_db)
    return [HalfPowerPeak(int(i), float(frequency_hz[i]), half_power(frequency_hz, amplitude, int(i))) for i in found]


def half_power(frequency_hz: Real, amplitude: Real, line: int) -> float:
    """zeta = (f2 - f1) / (2 f0), f1 and f2 where the amplitude is 1 / sqrt(2) of the peak line's.

    The lines in between are joined by straight ones. NaN if the amplitude does not fall that far on both sides before
    it rises again.

    Raises:
        DataError: as for `find_peaks`, or no such line.
    """
    _check_curve(frequency_hz, amplitude)
    if not 0 <= line < amplitude.size:
        raise DataError(f"there is no line {line} among {amplitude.size}", remedy="count the lines from 0")
    limit = amplitude[line] / np.sqrt(2)
    low, high = (
        _half_power_crossing(frequency_hz, amplitude, line, -1, limit),
        _half_power_crossing(frequency_hz, amplitude, line, 1, limit),
    )
    return (high - low) / (2 * float(frequency_hz[line]))


def _half_power_crossing(frequency_hz: Real, amplitude: Real, line: int, step: int, limit: float) -> float:
    i = line
    while 0 <= i + step < amplitude.size:
        if amplitude[i + step] > amplitude[i]:
            return float("nan")
        if amplitude[i + step] <= limit:
            share = (amplitude[i] - limit) / (amplitude[i] - amplitude[i + step])
            return float(frequency_hz[i] + share * (frequency_hz[i + step] - frequency_hz[i]))
        i += step
    return float("nan")


def _check_curve(frequency_hz: Real, amplitude: Real) -> None:
    check_frequencies(frequency_hz, even=False)
    if amplitude.shape != frequency_hz.shape or not (np.isfinite(amplitude).all() and np.all(amplitude >= 0)):
        raise DataError(
            f"{frequency_hz.shape} frequencies and amplitudes {amplitude.shape} are no curve, or some NaN or negative",
            remedy="give the amplitude of an FRF at each of its lines",
        )


def half_power_near(frequency_hz: Real, amplitude: Real, requested_hz: float) -> float:
    """Half-power damping ratio of the peak that belongs to a mode at `requested_hz`.

    It climbs from the nearest line to the top of its hill, and reads there.

    Raises:
        DataError: as for `find_peaks`, or a frequency that is none.
    """
    _check_curve(frequency_hz, amplitude)
    if not np.isfinite(requested_hz):
        raise DataError(f"there is no mode at {requested_hz} Hz", remedy="give a frequency in Hz")
    line = int(np.argmin(np.abs(frequency_hz - requested_hz)))
    while True:
        best = max((line - 1, line, line + 1), key=lambda i: amplitude[i] if 0 <= i < amplitude.size else -1.0)
        if best == line:
            return half_power(frequency_hz, amplitude, line)
        line = best


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
