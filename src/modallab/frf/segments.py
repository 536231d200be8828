"""Spectra of a long record in stretches that overlap, for averaging.

Source: Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Trans. Audio Electroacoust.
15 (1967), 70-73, on overlap and on how many averages it is worth.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.signals.checks import check_rows

Window = Literal["none", "hann"]


@dataclass(frozen=True, eq=False, slots=True)
class SegmentSpectra:
    """Spectra of stretches of one record.

    Attributes:
        frequency_hz: (lines,) of the stretches, the lines at 0 Hz and at half the rate left out.
        spectra: (stretches, channels, lines), times the window; what they are scaled by is the same for all channels.
        averages: how many stretches that do not overlap hold as much information, of a record of broad-band noise.
    """

    frequency_hz: Real
    spectra: NDArray[np.complex128]
    averages: float


def segment_spectra(
    values: Real, rate_hz: float, length: int, overlap: float = 0.5, window: Window = "hann"
) -> SegmentSpectra:
    """Spectra of the stretches of a record, each without its mean.

    A Hann window keeps leakage low and widens every peak by a line and a half: damping read off such a peak is too
    large. Without leakage and without a window: `local_polynomial_frf`.

    Args:
        values: (channels, n).
        rate_hz: sampling rate.
        length: samples in a stretch.
        overlap: share of a stretch that the next one has as well, below 1; a Hann window gains up to some 0.66.
        window: over each stretch.

    Raises:
        DataError: values that are no records, a stretch longer than they are or shorter than 8, no such overlap.
    """
    check_rate(rate_hz)
    check_rows(values)
    if values.ndim != 2 or not 8 <= length <= values.shape[-1]:
        raise DataError(
            f"stretches of {length} samples cannot be cut from a record of shape {values.shape}",
            remedy="give (channels, n), and stretches of at least 8 and at most n samples",
        )
    if not 0 <= overlap < 1:
        raise DataError(f"an overlap of {overlap} is none", remedy="give a share from 0 to below 1")
    step = max(1, round(length * (1 - overlap)))
    shape = np.ones(length) if window == "none" else np.hanning(length + 1)[:-1]
    starts = np.arange(0, values.shape[1] - length + 1, step)
    cut = np.stack([values[:, s : s + length] for s in starts])
    cut = (cut - cut.mean(axis=-1, keepdims=True)) * shape
    every = slice(1, (length + 1) // 2)
    spectra: NDArray[np.complex128] = np.fft.rfft(cut)[..., every]
    frequency = np.arange(length // 2 + 1)[every] * rate_hz / length
    return SegmentSpectra(frequency, spectra, _independent_averages(shape, step, len(starts)))


def _independent_averages(shape: NDArray[Any], step: int, count: int) -> float:
    """Welch's count: K / (1 + 2 sum (1 - k / K) rho_k), rho_k the squared correlation of windows k steps apart."""
    power = float(shape @ shape)
    apart = [k for k in range(1, count) if k * step < shape.size]
    rho = [(float(shape[k * step :] @ shape[: -k * step]) / power) ** 2 for k in apart]
    return count / (1 + 2 * sum((1 - k / count) * r for k, r in zip(apart, rho, strict=True)))
