"""Step A: the paper's band-pass FIR, with its delay removed."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.signals.checks import check_rows
from modallab.signals.transform import next_quick_length

MOST_TAPS = 2**20
"""A lower edge that needs more is as good as none."""


def bandpass(
    values: NDArray[np.float64], rate_hz: float, band_hz: tuple[float, float], taps: int | None = None
) -> NDArray[np.float64]:
    """Linear-phase FIR band-pass along the last axis; the output stands where the input does.

    A lower edge of 3 Hz needs about 1.1 s of taps (2200 at 2 kHz), more than a block of 1.024 s: the filter acts on
    a block as if zeros lay around it. It is for looking at, and for comparing two records treated alike;
    identification uses unfiltered samples.

    Args:
        values: (..., n).
        rate_hz: sampling rate.
        band_hz: lower and upper edge (-6 dB).
        taps: odd length; by default 3.3 / (transition width in cycles per sample) with a width of the lower edge.

    Raises:
        DataError: the band does not lie inside 0 to rate / 2; an even number of taps, or over a million;
            samples that are no numbers.
    """
    check_rate(rate_hz)
    check_rows(values.reshape(-1) if values.ndim > 2 else values)
    low, high = band_hz
    if not 0 < low < high < rate_hz / 2:
        raise DataError(
            f"band {low:g} to {high:g} Hz does not fit a rate of {rate_hz:g} Hz",
            remedy=f"choose a band inside 0 to {rate_hz / 2:g} Hz",
        )
    if taps is not None and (taps < 3 or taps % 2 == 0):
        raise DataError(f"{taps} taps have no centre sample", remedy="give an odd number of at least 3 taps")
    length = taps if taps is not None else int(3.3 * rate_hz / low) // 2 * 2 + 1
    if length > MOST_TAPS:
        found = f"a lower edge of {low:g} Hz at a rate of {rate_hz:g} Hz needs {length} taps"
        raise DataError(found, remedy="raise the lower edge, or subtract the mean instead")
    quick = next_quick_length(values.shape[-1] + length - 1)
    lines = np.fft.rfft(values, quick) * np.fft.rfft(
        _impulse_response(length, 2 * low / rate_hz, 2 * high / rate_hz), quick
    )
    delay = (length - 1) // 2
    return np.fft.irfft(lines, quick)[..., delay : delay + values.shape[-1]]


def _impulse_response(length: int, low: float, high: float) -> Real:
    """(length,) impulse response of a band, its edges over half the rate: ideal under a Hamming window, 1 midway."""
    n = np.arange(length) - (length - 1) / 2
    ideal = (high * np.sinc(high * n) - low * np.sinc(low * n)) * np.hamming(length)
    return ideal / np.sum(ideal * np.cos(np.pi * n * (low + high) / 2))


def remove_mean(values: Real) -> Real:
    """Values (n,) or (rows, n) with each row's mean taken off: the paper's non-zero mean cancellation.

    Raises:
        DataError: values that are no records.
    """
    check_rows(values)
    return values - values.mean(axis=-1, keepdims=True)
