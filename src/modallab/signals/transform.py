"""Fourier transforms of real records, and the numbers of samples that they take quickly.

SciPy keeps what it has worked out for a length, so its transforms of long records take a fifth of NumPy's time. Of
short ones they save microseconds, and loading SciPy takes a quarter of the time in which a bench's process begins. So
it is loaded where a long record is to be transformed.
"""

from functools import lru_cache
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.signals.checks import check_rows

SHORT = 2**15
"""Samples of a record up to which NumPy's transform is as good."""
QUICK_FACTORS = (2, 3, 5)


def spectrum(record: NDArray[Any], n: int | None = None) -> NDArray[Any]:
    """(n // 2 + 1,) lines of a real record (m,), cut or filled with zeros to `n` samples; in the record's precision."""
    if (record.size if n is None else n) <= SHORT:
        return np.fft.rfft(record, n)
    from scipy import fft

    return np.asarray(fft.rfft(record, n))


@lru_cache(maxsize=64)
def next_quick_length(n: int) -> int:
    """The least number of at least `n` samples that has no prime factor above 5, as a quick transform needs.

    Raises:
        DataError: no samples.
    """
    return next(m for m in count(_check_length(n)) if _is_quick(m))


@lru_cache(maxsize=64)
def previous_quick_length(n: int) -> int:
    """The greatest number of at most `n` samples that has no prime factor above 5.

    Raises:
        DataError: no samples.
    """
    return next(m for m in range(_check_length(n), 0, -1) if _is_quick(m))


def _check_length(n: int) -> int:
    if n < 1:
        raise DataError(f"a transform of {n} samples is none", remedy="give at least one sample")
    return n


def _is_quick(n: int) -> bool:
    for factor in QUICK_FACTORS:
        while n % factor == 0:
            n //= factor
    return n == 1


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
