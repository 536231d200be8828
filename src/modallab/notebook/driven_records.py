"""Records of several forces that act at once, as arrays: FRFs of several shakers."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modallab.core.array_checks import check_rate
from modallab.core.arrays import Complex128, Real
from modallab.core.digits import percent_text
from modallab.core.errors import DataError
from modallab.core.frf import FrfQuantity
from modallab.frf.broadband import segment_spectra
from modallab.frf.local_polynomial import local_polynomial_frf
from modallab.frf.references import estimate_frf
from modallab.frf.sums import Estimator
from modallab.notebook.measured_frf import MeasuredFrf, frf

ForceEstimator = Literal["local-polynomial", "H1", "H2", "Hv"]
ESTIMATORS: tuple[ForceEstimator, ...] = ("local-polynomial", "H1", "H2", "Hv")
MOST_LINES = 9000
"""Of a record by the local polynomial method: each line is a small least-squares problem of its own."""
UNDRIVEN, TOGETHER = 0.03, 16
"""Share of a force's rms in the band below which so many lines that follow each other are not driven."""


def driven(
    forces: ArrayLike,
    responses: ArrayLike,
    rate_hz: float,
    inputs: Sequence[int] | None = None,
    outputs: Sequence[int] | None = None,
    *,
    band: tuple[float, float],
    estimator: ForceEstimator = "local-polynomial",
    block_s: float | None = None,
    quantity: FrfQuantity = "inertance",
) -> MeasuredFrf:
    """FRFs of a structure driven by several measured forces at the same time, for `ml.identify`.

    The local polynomial method uses the whole record without window or leakage. H1, H2 and Hv average segments of
    `block_s` with a Hann window, whose peaks are a line and a half too wide.

    Args:
        forces: (inputs, samples) in N; random and different.
        responses: (outputs, samples) in SI, at the same times.
        rate_hz: sampling rate.
        inputs: number of the point of each force.
        outputs: number of the point of each response (default: 1, 2, ...).
        band: lowest and highest driven frequency, Hz.
        estimator: local-polynomial, H1, H2 or Hv.
        block_s: length of a segment for H1, H2 and Hv.
        quantity: kind of FRF: inertance, mobility or receptance.

    Raises:
        DataError: records of different length, a band without a drive, or forces that cannot be distinguished.
    """
    f, y = _rows_of_records(forces, "forces"), _rows_of_records(responses, "responses")
    if f.shape[1] != y.shape[1]:
        raise DataError(
            f"the forces have {f.shape[1]} samples, the responses {y.shape[1]}",
            remedy="give one record of all channels",
        )
    if estimator not in ESTIMATORS:
        raise DataError(f"no estimator is called {estimator!r}", remedy=f"use one of {', '.join(ESTIMATORS)}")
    rate = check_rate(rate_hz, "rate_hz")
    if estimator == "local-polynomial":
        hz, values = _frf_by_local_polynomials(f, y, rate, band)
    else:
        hz, values = _frf_by_segments(f, y, rate, band, estimator, block_s)
    return frf(hz, values, inputs, outputs, quantity)


def _frf_by_local_polynomials(f: Real, y: Real, rate: float, band: tuple[float, float]) -> tuple[Real, Complex128]:
    n = min(f.shape[1], int(MOST_LINES * rate / (band[1] - band[0])))
    count = f.shape[1] // n
    every = np.arange(n // 2 + 1) * rate / n
    chosen = _lines_inside(every, band)
    of_forces, of_responses = (_segment_spectra(rows, n, count)[..., chosen] for rows in (f, y))
    _check_driven(of_forces, band)
    values, _ = local_polynomial_frf(of_forces, of_responses)
    return every[chosen], values


def _frf_by_segments(
    f: Real, y: Real, rate: float, band: tuple[float, float], estimator: Estimator, block_s: float | None
) -> tuple[Real, Complex128]:
    if block_s is None:
        raise DataError(f"{estimator} averages stretches, whose length is not given", remedy="give block_s")
    cut = segment_spectra(np.concatenate([f, y]), rate, round(block_s * rate))
    chosen = _lines_inside(cut.frequency_hz, band)
    spectra = cut.spectra[..., chosen]
    _check_driven(spectra[:, : len(f)], band)
    found = estimate_frf(spectra[:, : len(f)], spectra[:, len(f) :], estimator, cut.averages)
    return cut.frequency_hz[chosen], found.frf


def _segment_spectra(rows: Real, n: int, count: int) -> Complex128:
    cut = rows[:, : n * count].reshape(len(rows), count, n).transpose(1, 0, 2)
    return np.asarray(np.fft.rfft(cut - cut.mean(axis=-1, keepdims=True)), np.complex128)


def _lines_inside(hz: Real, band: tuple[float, float]) -> NDArray[np.bool_]:
    inside = (hz > 0) & (hz >= band[0]) & (hz <= band[1])
    if np.count_nonzero(inside) < 8:
        raise DataError(
            f"the band of {band[0]:g} to {band[1]:g} Hz holds {np.count_nonzero(inside)} lines",
            remedy="widen the band, or record longer",
        )
    return inside


def _check_driven(forces: Complex128, band: tuple[float, float]) -> None:
    power = np.mean(np.abs(forces) ** 2, axis=0)
    begins = np.arange(0, power.shape[1], TOGETHER)
    few = np.add.reduceat(power, begins, axis=1) / np.diff(np.append(begins, power.shape[1]))
    undriven = np.sqrt(few) < UNDRIVEN * np.sqrt(np.mean(power, axis=1, keepdims=True))
    if np.any(undriven) or not np.all(power.any(axis=1)):
        share = float(np.mean(undriven.any(axis=0)))
        raise DataError(
            f"a force has no content at {percent_text(share)} of {band[0]:g} to {band[1]:g} Hz",
            remedy="narrow the band to the driven frequencies",
        )


def _rows_of_records(given: ArrayLike, name: str) -> Real:
    try:
        found = np.atleast_2d(np.asarray(given, np.float64))
    except (TypeError, ValueError) as error:
        raise DataError(
            f"{name} are no array of real numbers: {error}", remedy=f"give {name} (rows, samples)"
        ) from error
    if found.ndim != 2 or found.shape[1] < found.shape[0] or not np.isfinite(found).all():
        raise DataError(
            f"{name} have the shape {found.shape}, or hold values that are not finite",
            remedy=f"give {name} (rows, samples), one record",
        )
    return found
