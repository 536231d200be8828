"""A sine in noise: least squares at a known frequency, and with the frequency (IEEE Std 1057, 3 and 4 parameters)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.signals.checks import check_positive, check_rows


@dataclass(frozen=True, eq=False, slots=True)
class SineFit:
    """x(t) = offset + Re(amplitude exp(j 2 pi f t)), t from the first sample.

    Attributes:
        frequency_hz: fitted or given.
        amplitude: (channels,) complex peak amplitude.
        offset: (channels,)
        residual_rms: (channels,)
    """

    frequency_hz: float
    amplitude: NDArray[np.complex128]
    offset: NDArray[np.float64]
    residual_rms: NDArray[np.float64]


def fit_at(values: NDArray[np.float64], rate_hz: float, frequency_hz: float) -> SineFit:
    """Three-parameter fit of each row of values (channels, n) at a known frequency.

    Raises:
        DataError: values that are no records, too few samples, or a frequency outside 0 to rate / 2.
    """
    _check(values, rate_hz, frequency_hz)
    t = np.arange(values.shape[1]) / rate_hz
    angle = 2 * np.pi * frequency_hz * t
    basis = np.stack([np.cos(angle), -np.sin(angle), np.ones_like(t)], axis=1)
    solution, *_ = np.linalg.lstsq(basis, values.T, rcond=None)
    residual = values - (basis @ solution).T
    return SineFit(frequency_hz, solution[0] + 1j * solution[1], solution[2], np.sqrt(np.mean(residual**2, axis=1)))


def fit_frequency(values: NDArray[np.float64], rate_hz: float, near_hz: float, iterations: int = 8) -> SineFit:
    """Four-parameter fit: the frequency too, shared by all rows of values (channels, n), by Gauss-Newton.

    Args:
        values: (channels, n).
        rate_hz: sampling rate.
        near_hz: start value, within about half a line of the truth.
        iterations: at most this many steps.

    Raises:
        DataError: no step at all is asked for; the frequency runs away by more than one line: there is no such sine;
            or as for `fit_at`.
    """
    _check(values, rate_hz, near_hz)
    check_positive(iterations, "the number of steps")
    n = values.shape[1]
    t = np.arange(n) / rate_hz
    frequency = near_hz
    for _ in range(iterations):
        step = _frequency_step(values, t, fit_at(values, rate_hz, frequency))
        frequency += step
        if abs(frequency - near_hz) > rate_hz / n:
            raise DataError(
                f"no sine near {near_hz:.4g} Hz: the fit ran to {frequency:.4g} Hz",
                remedy="check that the generator was on and set to the recorded frequency",
            )
        if abs(step) < 1e-9 * near_hz:
            break
    return fit_at(values, rate_hz, frequency)


def strongest_near(values: NDArray[np.float64], rate_hz: float, requested_hz: float) -> float:
    """Frequency of the strongest sine in values (n,) within two lines or 5 % of the requested one: a start for the fit.

    Generator and converter each have a clock of their own; a wrong one may be off by more than a line. Where there is
    nothing but a level, it is the requested one.

    Raises:
        DataError: as for `fit_at`.
    """
    _check(values[None], rate_hz, requested_hz)
    n = values.size
    window = np.hanning(n)
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * window, 8 * n))
    frequency = np.arange(spectrum.size) * rate_hz / (8 * n)
    inside = np.abs(frequency - requested_hz) <= max(2 * rate_hz / n, 0.05 * requested_hz)
    if spectrum[inside].max(initial=0.0) <= 1e-12 * n * float(np.abs(values).max()):
        return requested_hz
    found = float(frequency[inside][np.argmax(spectrum[inside])])
    # Below a few lines the window's lobe of the negative frequency is in the way; there the requested one will do.
    return found if abs(found - requested_hz) > 0.5 * rate_hz / n and requested_hz > 4 * rate_hz / n else requested_hz


def _check(values: NDArray[np.float64], rate_hz: float, frequency_hz: float) -> None:
    check_rate(rate_hz)
    check_positive(frequency_hz, "the sine's frequency in Hz")
    check_rows(values)
    if values.ndim != 2 or values.shape[1] < 8:
        raise DataError(f"the record has shape {values.shape}", remedy="give (channels, n) with at least 8 samples")
    if frequency_hz >= rate_hz / 2:
        found = f"a sine at {frequency_hz:g} Hz cannot be seen at a rate of {rate_hz:g} Hz"
        raise DataError(found, remedy="check the rate and the frequency of the record")


def _frequency_step(values: NDArray[np.float64], t: NDArray[np.float64], fit: SineFit) -> float:
    angle = 2 * np.pi * fit.frequency_hz * t
    basis = np.stack([np.cos(angle), -np.sin(angle), np.ones_like(t)], axis=1)
    slope = np.real(fit.amplitude[:, None] * 2j * np.pi * t * np.exp(1j * angle))
    orthonormal, _ = np.linalg.qr(basis)
    slope -= slope @ orthonormal @ orthonormal.T
    power = float(np.sum(slope * slope))
    # A record of zeros holds no sine to follow.
    return float(np.sum(slope * values)) / power if power > 0 else 0.0
