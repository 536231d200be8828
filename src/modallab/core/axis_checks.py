"""Checks on rates and on the axes of time and frequency."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError

_any_number = np.errstate(over="ignore", invalid="ignore", divide="ignore")
"""Axes of absurd numbers are rejected, without a warning from NumPy on the way."""


_SAME = 1e-9
_SIGMAS = 6.0
_EVEN = 0.01
"""Share of a step by which a sample may deviate from an even grid: half a degree of phase at a tenth of the rate."""


def check_rate(rate_hz: float, where: str = "") -> float:
    """A sampling rate in Hz, if it is one: finite and above 0.

    Raises:
        DataError: it is not.
    """
    if not (np.isfinite(rate_hz) and rate_hz > 0):
        raise DataError(f"the sampling rate is {rate_hz} Hz", where=where, remedy="give a rate above 0 Hz")
    return float(rate_hz)


@_any_number
def check_time(time_s: ArrayLike, where: str = "", *, resolution_s: ArrayLike = 0.0) -> float:
    """The rate in Hz of evenly spaced times.

    Where a whole number of Hz agrees with the times to within their resolution, it is that number. Numbers in single
    precision have a resolution of their own.

    Args:
        time_s: (n,) times in s.
        where: file and record, for the message.
        resolution_s: half of the last digit with which the times were written, of each (n,) or one for all.

    Raises:
        DataError: times that do not ascend, or are spaced unevenly, or written too coarsely to show it.
    """
    times = np.asarray(time_s, dtype=np.float64)
    resolution = np.broadcast_to(np.maximum(resolution_s, _stored_digit(np.asarray(time_s))), times.shape)
    _check_ascending(times, "time", "s", where, resolution)
    _check_even(times, "time", "s", where, resolution)
    n, places = len(times), np.arange(len(times)) - (len(times) - 1) / 2
    step = float(places @ (times - times[0]) / (places @ places))
    # Rounding is even within the last digit: sigma is its half over root 3, and that of a slope 12 / n^3 in square.
    step_sigma = np.sqrt(np.mean(resolution**2) / 3.0 * 12.0 / n**3)
    rate = 1.0 / step if step > 0 else 0.0
    slack = _SIGMAS * rate * rate * step_sigma
    return check_rate(nearest_whole_rate(float(rate), float(slack)), where)


def _stored_digit(numbers: NDArray[Any]) -> float:
    """Half of the last digit of numbers in single precision or less; 0 for others."""
    if numbers.dtype.kind != "f" or numbers.dtype.itemsize > 4 or not np.isfinite(numbers).all():
        return 0.0
    return float(np.spacing(np.abs(numbers).max(initial=0))) / 2


def nearest_whole_rate(rate_hz: float, slack_hz: float) -> float:
    """The whole number of Hz within `slack_hz` of a rate, if there is just one; else the rate itself."""
    slack_hz += _SAME * rate_hz
    whole = np.ceil(rate_hz - slack_hz)
    return float(whole if whole > 0 and whole == np.floor(rate_hz + slack_hz) else rate_hz)


@_any_number
def check_frequencies(
    frequency_hz: ArrayLike, where: str = "", *, even: bool = True, resolution_hz: ArrayLike = 0.0
) -> None:
    """Reject frequencies that are negative, do not ascend strictly or, if `even`, are spaced unevenly.

    Args:
        frequency_hz: (lines,) in Hz.
        where: file and record, for the message.
        even: whether the lines must be equally spaced, as those of an FFT are.
        resolution_hz: half of the last digit with which the frequencies were written, of each or one for all.

    Raises:
        DataError: they are not as they must be.
    """
    lines = np.asarray(frequency_hz, dtype=np.float64)
    resolution = np.broadcast_to(np.asarray(resolution_hz, np.float64), lines.shape)
    _check_ascending(lines, "frequency", "Hz", where, resolution)
    if lines[0] < 0:
        raise DataError(
            f"the frequencies begin at {lines[0]:g} Hz", where=where, remedy="give the lines from 0 Hz upwards only"
        )
    if even:
        _check_even(lines, "frequency", "Hz", where, resolution)


def _check_ascending(values: NDArray[np.float64], what: str, unit: str, where: str, resolution: Real) -> None:
    if values.ndim != 1 or len(values) < 2:
        raise DataError(
            f"the {what} axis has shape {values.shape}", where=where, remedy="give one axis with at least two values"
        )
    if not np.isfinite(values).all():
        at = int((~np.isfinite(values)).argmax())
        raise DataError(
            f"the {what} axis holds {values[at]} at place {at}", where=where, remedy=f"correct the {what} axis"
        )
    steps = np.diff(values)
    if (steps > 0).all():
        return
    if (steps >= 0).all():
        _check_digits(float(steps.mean()), what, unit, where, resolution)
    if (steps < 0).all():
        found, remedy = f"the {what} axis descends", "reverse the record, samples and axis together"
    else:
        at = int((steps <= 0).argmax())
        found = f"the {what} axis does not ascend: {values[at]:g} {unit} is followed by {values[at + 1]:g} {unit}"
        remedy = f"sort the record by {what}, each value once"
    raise DataError(found, where=where, remedy=remedy)


def _check_even(values: NDArray[np.float64], what: str, unit: str, where: str, resolution: Real) -> None:
    step = (values[-1] - values[0]) / (len(values) - 1)
    away = np.abs(values - (values[0] + step * np.arange(len(values))))
    if float(away.max()) <= _EVEN * step:
        return
    # The ends are rounded as well, so the grid through them may deviate by as much again.
    exceed = away - resolution - max(resolution[0], resolution[-1])
    worst = int(exceed.argmax())
    if not exceed[worst] <= _EVEN * step:  # NaN, from absurd numbers, is uneven too
        raise DataError(
            f"the {what} axis is uneven: place {worst} stands {away[worst] / step:.3g} steps of {step:g} {unit} "
            "off an even grid",
            where=where,
            remedy=f"record or resample at an even {what} step; look for lost samples there",
        )
    _check_digits(float(step), what, unit, where, resolution)


def _check_digits(step: float, what: str, unit: str, where: str, resolution: Real) -> None:
    coarsest = float(resolution.max())
    if 2 * coarsest > step / 4:
        raise DataError(
            f"the {what} axis is written too coarsely: steps of {step:g} {unit}, digits of {2 * coarsest:g} {unit}",
            where=where,
            remedy=f"write the {what} axis with more digits"
            + (", or leave it out and give the rate with --rate" if what == "time" else ""),
        )
