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


def frequency_of_sine(values: NDArray[np.float64], rate_hz: float, near_hz: float) -> float:
    """Frequency in Hz of the sine in (n,) values near `near_hz`; `near_hz` itself where there is no sine to follow.

    Raises:
        DataError: as for `fit_at`.
    """
    _check(values[None], rate_hz, near_hz)
    try:
        found = fit_frequency(values[None], rate_hz, near_hz).frequency_hz
    except DataError:
        return near_hz
    return found if abs(found - near_hz) <= rate_hz / values.size / 2 else near_hz


def fit_tone(force: NDArray[np.float64], rate_hz: float, requested_hz: float | None, where: str = "") -> SineFit:
    """The sine in a block's force (n,), at its own frequency, which the generator's clock decides.

    Raises:
        DataError: no frequency is known, or no such sine stands out of the noise.
    """
    if requested_hz is None:
        raise DataError("no frequency is recorded", where=where, remedy="give the record's frequency_hz")
    fit = fit_frequency(force[None], rate_hz, strongest_line_near(force, rate_hz, requested_hz))
    if np.abs(fit.amplitude[0]) < 5 * fit.residual_rms[0] * np.sqrt(2 / force.size):
        raise DataError(
            f"no sine at {requested_hz:.4g} Hz in the force: {np.abs(fit.amplitude[0]):.3g} N",
            where=where,
            remedy="check that the shaker was on, or leave the record out",
        )
    return fit


def strongest_line_near(values: NDArray[np.float64], rate_hz: float, requested_hz: float) -> float:
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
    slope = _slope_by_frequency(t, fit)
    power = float(np.sum(slope * slope))
    # A record of zeros holds no sine to follow.
    return float(np.sum(slope * values)) / power if power > 0 else 0.0


def clock_ratio(
    forces: NDArray[np.float64], rate_hz: float, set_hz: NDArray[np.float64], sigma: float
) -> tuple[float, float]:
    """Frequency of sines over what their generator was set to: one number for all blocks, and its deviation.

    Gauss-Newton on the one ratio, amplitudes and means of all blocks solved for (IEEE Std 1057, 4 parameters).

    Args:
        forces: (blocks, n) N.
        rate_hz: sampling rate.
        set_hz: (blocks,) what the generator was set to.
        sigma: noise of a sample, N.
    """
    ratio, spread = _coarse_ratio(forces, rate_hz, set_hz), np.inf
    t = np.arange(forces.shape[1]) / rate_hz
    for _ in range(6):
        num, den = 0.0, 0.0
        for force, f0 in zip(forces, set_hz * ratio, strict=True):
            fit = fit_at(force[None], rate_hz, float(f0))
            slope = _slope_by_frequency(t, fit)[0] * f0
            num += float(slope @ force)
            den += float(slope @ slope)
        step = num / den if den > 0 else 0.0
        ratio *= 1 + step
        spread = sigma / np.sqrt(den) if den > 0 else np.inf
        if abs(step) < 1e-9:
            break
    return ratio, float(spread)


def _coarse_ratio(forces: NDArray[np.float64], rate_hz: float, set_hz: NDArray[np.float64]) -> float:
    grid = np.arange(-0.1, 0.1001, 0.002)
    t = np.arange(forces.shape[1]) / rate_hz
    # The highest frequencies tell a ratio best.
    top = np.argsort(set_hz)[-6:]
    sizes = np.sqrt(np.maximum(np.sum(forces[top] ** 2, axis=1, keepdims=True), 1e-300))
    windowed = forces[top] * np.hanning(len(t)) / sizes
    angle = -2j * np.pi * set_hz[top, None] * t
    # From one ratio to the next every sample turns by the same angle: a product, and no exponential.
    turned, step = np.exp(angle * (1 + grid[0])), np.exp(angle * (grid[1] - grid[0]))
    power: list[float] = []
    for _ in grid:
        power.append(float(np.sum(np.abs(np.sum(windowed * turned, axis=1)) ** 2)))
        turned = turned * step
    return 1 + float(grid[int(np.argmax(power))])


def _slope_by_frequency(t: NDArray[np.float64], fit: SineFit) -> NDArray[np.float64]:
    """(channels, n) derivative of the fitted sines by their frequency, less what amplitude and mean take over."""
    angle = 2 * np.pi * fit.frequency_hz * t
    basis = np.stack([np.cos(angle), -np.sin(angle), np.ones_like(t)], axis=1)
    slope = np.real(fit.amplitude[:, None] * 2j * np.pi * t * np.exp(1j * angle))
    orthonormal, _ = np.linalg.qr(basis)
    return slope - slope @ orthonormal @ orthonormal.T
