"""FRFs of a broadband test: H1, H2 or Hv over its blocks, with the window that its signal asks for.

Source: Welch, "The use of fast Fourier transform for the estimation of power spectra", IEEE Trans. Audio Electroacoust.
15 (1967), 70-73, on overlap and on how many averages it is worth.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.arrays import Complex128, Real
from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND
from modallab.frf.estimate import combine_spectra, lines_of_band, output_quantity
from modallab.frf.references import estimate_frf
from modallab.frf.sums import Estimator, check_averages
from modallab.signals.block_sets import check_outputs, check_test
from modallab.signals.checks import check_rows
from modallab.signals.signals import Signals

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


DRIVEN_DB = 20.0
"""A line is driven where the force's spectrum, smoothed over some lines, is within this of its highest."""

SMOOTHED = 9
PERIODIC = ("pseudo-random", "chirp")
LEFT_OUT = 1e-3
"""Share of the strongest neighbour's power below which a line of a periodic drive holds no drive."""


def broadband_frf(
    signals: Sequence[Signals],
    rig: Rig,
    band_hz: tuple[float, float],
    driven_by: Sequence[Signals] | None = None,
    estimator: Estimator = "H1",
) -> Frf:
    """FRF and coherence of blocks of one level, by every force that drove: multiple coherence where several did.

    Blocks of random drive get a Hann window, which keeps leakage low and widens every peak by a line and a half. Blocks
    of the other signals hold whole periods, or a burst and its decay, and get none. Of a periodic drive the lines that
    it leaves out are left out: there the FRF would be noise over noise.

    Args:
        signals: blocks, equal in rate and length.
        rig: names, points and quantities.
        band_hz: lines to give.
        driven_by: blocks whose force says which lines are driven; None for `signals`.
        estimator: H1, H2 or Hv.

    Raises:
        DataError: no blocks, blocks that differ, of several signals or of another test, a band without lines, or one
            block for H2 or Hv.
    """
    check_test(signals)
    check_averages(estimator, [len(signals)], "blocks")
    first = signals[0]
    check_outputs(first, rig)
    tests = {s.block.test for s in signals}
    if len(tests) > 1 or first.block.test not in BROADBAND:
        raise DataError(
            f"blocks of {', '.join(sorted(tests))} make no broadband FRF", remedy="give the blocks of one signal"
        )
    n, rate = first.n_samples, first.rate_hz
    chosen = lines_of_band(n, rate, band_hz)
    if first.block.test in PERIODIC:
        chosen = driven_lines(chosen, driven_by or signals)
    window = _data_window(n, hann=first.block.test == "random")
    force = np.stack([_windowed_spectrum(s.forces, window)[:, chosen] for s in signals])
    response = np.stack([_windowed_spectrum(s.responses, window)[:, chosen] for s in signals])
    values, coherence, variance = _estimate_frf(force, response, estimator)
    return Frf(
        frequency_hz=chosen * rate / n,
        values=values,
        quantity=output_quantity(rig),
        outputs=first.outputs,
        output_points=tuple(c.point for c in rig.responses),
        input_points=first.block.driven_points,
        coherence=coherence,
        variance=variance,
        averages=(len(signals),) * len(first.forces),
    )


def _estimate_frf(
    force: Complex128, response: Complex128, estimator: Estimator
) -> tuple[Complex128, Real, Real | None]:
    """(outputs, inputs, lines) FRF, coherence and variance; one force needs no second block, which shows no variance.

    Args:
        force: (blocks, inputs, lines)
        response: (blocks, outputs, lines)
        estimator: H1, H2 or Hv.
    """
    if force.shape[1] == 1:
        values, coherence = combine_spectra(force[:, 0], response, estimator)
        return values[:, None], coherence[:, None], None
    found = estimate_frf(force, response, estimator)
    coherence = np.repeat(found.coherence[:, None], force.shape[1], axis=1)
    return found.frf, coherence, found.variance


def driven_band(signals: Sequence[Signals]) -> tuple[float, float]:
    """From the lowest to the highest frequency that every force holds.

    Raises:
        DataError: no blocks, or blocks that differ.
    """
    check_test(signals)
    n, rate = signals[0].n_samples, signals[0].rate_hz
    # Leakage of a plain cut would reach far beyond the band; a window would take the ends off a chirp.
    window = _data_window(n, hann=signals[0].block.test in ("random", "burst-random"))
    powers = np.mean([np.abs(_windowed_spectrum(s.forces, window)) ** 2 for s in signals], axis=0)
    edges = [_driven_edges(power) for power in powers]
    low, high = max(first for first, _ in edges), min(last for _, last in edges)
    return low * rate / n, max(low + 4, ceil(high)) * rate / n


def _driven_edges(power: Real) -> tuple[int, int]:
    """First and last of the lines where there is power."""
    smooth = np.convolve(power, np.ones(SMOOTHED) / SMOOTHED, mode="same")
    driven = np.flatnonzero(smooth > smooth.max() * 10 ** (-DRIVEN_DB / 10))
    # Smoothing reaches half its width beyond the band.
    half = SMOOTHED // 2
    return max(1, int(driven[0]) + half - 1), int(driven[-1]) - half + 1


def driven_lines(chosen: NDArray[np.int64], signals: Sequence[Signals]) -> NDArray[np.int64]:
    """Those of the lines that a periodic drive holds, each of its forces.

    Raises:
        DataError: fewer than 4.
    """
    powers = np.mean([np.abs(_windowed_spectrum(s.forces, np.ones(s.n_samples))) ** 2 for s in signals], axis=0)
    candidates_nearby = ndimage.maximum_filter1d(powers, SMOOTHED, axis=-1)
    used = chosen[np.all(powers[:, chosen] > LEFT_OUT * candidates_nearby[:, chosen], axis=0)]
    if used.size < 4:
        raise DataError(f"the drive holds {used.size} lines of the band", remedy="widen the band")
    return used


def blocks_of_one_level(signals: Sequence[Signals]) -> list[Signals]:
    """The blocks of the level that has most: FRFs of different levels are compared, never averaged."""
    levels = [s.block.level for s in signals]
    most = max(levels, key=levels.count, default=None)
    return [s for s in signals if s.block.level == most]


def _data_window(n: int, *, hann: bool) -> NDArray[np.float64]:
    return np.hanning(n + 1)[:-1] if hann else np.ones(n)


def _windowed_spectrum(values: NDArray[np.float64], window: NDArray[np.float64]) -> NDArray[np.complex128]:
    return np.fft.rfft((values - values.mean(axis=-1, keepdims=True)) * window)
