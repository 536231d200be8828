"""Modes of responses alone: which poles are modes, and how well each is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError, IdentificationError
from modallab.core.progress import report_progress
from modallab.identification.response_only.covariances import covariances_by_band
from modallab.identification.response_only.looks import SSI_COV, ObservedMode, PoleMethod, modes_of_band, shapes_agree
from modallab.identification.response_only.periodic import (
    LOBE,
    STRETCHES,
    line_at,
    lines_in_words,
    steady_lines,
    without_line,
)

TWICE = 0.01
"""Relative distance of poles of two bands that are one."""


@dataclass(frozen=True, eq=False, slots=True)
class ResponseModes:
    """Modes by rising frequency.

    Attributes:
        frequency_hz: (modes,)
        damping_ratio: (modes,)
        frequency_sigma_hz: (modes,)
        damping_sigma: (modes,)
        shapes: (modes, outputs) 1 at the largest; their scale is not known.
        shape_sigma: (modes, outputs) of the complex number.
        confidence: (modes,) 0 to 1: in how many of the orders and block sizes a mode stands, times how near it is known
            to the best that its decays in the records allow.
        harmonics_hz: (lines,) of periodic excitation, which are no modes.
    """

    frequency_hz: Real
    damping_ratio: Real
    frequency_sigma_hz: Real
    damping_sigma: Real
    shapes: Complex128
    shape_sigma: Real
    confidence: Real
    harmonics_hz: Real


def response_modes(
    records: Sequence[Real], rate_hz: float, band_hz: tuple[float, float], method: PoleMethod = SSI_COV
) -> ResponseModes:
    """Modes of responses to a random force that was not measured.

    Args:
        records: each (outputs, samples), any length, of one set-up.
        rate_hz: their rate.
        band_hz: where modes are looked for.
        method: how poles are found.

    Raises:
        DataError: no records, records that differ in outputs or hold no motion, or too short ones.
        IdentificationError: no mode.
    """
    _check_records(records, rate_hz, band_hz)
    still = [r - r.mean(axis=1, keepdims=True) for r in records]
    modes, lines = _find_modes(still, rate_hz, band_hz, method), np.zeros(0)
    near = _line_width(records, rate_hz)
    # Beside a line others are not known yet: it is looked again until none is found in a place of its own.
    while (new := _periodic_lines(max(still, key=lambda r: r.shape[1]), rate_hz, band_hz, modes)).size:
        if not any(_far_from_others(line, lines, near) for line in new):
            break
        for line in new:
            still = [without_line(r, rate_hz, line) for r in still]
        modes, lines = _find_modes(still, rate_hz, band_hz, method), _each_line(np.append(lines, new), records, rate_hz)
    modes = [m for m in modes if not _is_line(m, lines, near)]
    if not modes:
        said = f"; {lines_in_words(lines)}" if lines.size else ""
        raise IdentificationError(
            f"no pole between {band_hz[0]:.4g} and {band_hz[1]:.4g} Hz is stable and known{said}",
            remedy="record longer, widen the band, or look whether the responses move at all",
        )
    return _modes_as_arrays(modes, lines)


def _find_modes(
    still: Sequence[Real], rate_hz: float, band_hz: tuple[float, float], method: PoleMethod
) -> list[ObservedMode]:
    scale = np.sqrt(np.mean(np.concatenate(still, axis=1) ** 2, axis=1))
    found: list[ObservedMode] = []
    parts = list(covariances_by_band([r / scale[:, None] for r in still], rate_hz, band_hz))
    for k, band in enumerate(parts):
        report_progress(k / len(parts), f"{band.low_hz:.3g} to {band.high_hz:.3g} Hz")
        found += modes_of_band(band, scale, method)
    return _each_once(found)


def _periodic_lines(record: Real, rate_hz: float, band_hz: tuple[float, float], modes: Sequence[ObservedMode]) -> Real:
    """(lines,) Hz of periodic excitation: poles that are lines, and lines that no pole stands for."""
    scaled = record / np.sqrt(np.mean(record**2, axis=1, keepdims=True))
    asked = [(m.value[0] / (2 * np.pi), line_at(scaled, rate_hz, m.value[0] / (2 * np.pi), m.value[1])) for m in modes]
    may_be_modes = [f for f, line in asked if line is None]
    near = _line_width([record], rate_hz)
    steady = np.array([f for f in steady_lines(scaled, rate_hz, band_hz) if _far_from_others(f, may_be_modes, near)])
    # Those whose phase is steady first: beside one of them, a mode looks even as well.
    return steady if steady.size else np.array([line for _, line in asked if line is not None])


def _line_width(records: Sequence[Real], rate_hz: float) -> float:
    """Hz within which a line is one that was found before, or a pole stands for it."""
    return LOBE * STRETCHES * rate_hz / max(r.shape[1] for r in records)


def _is_line(mode: ObservedMode, lines: Real, near: float) -> bool:
    """Whether a pole is what a wandering line left: as narrow as what was taken out, and in its place."""
    frequency = mode.value[0] / (2 * np.pi)
    return bool(mode.value[1] * frequency < near and not _far_from_others(frequency, lines, near))


def _far_from_others(frequency_hz: float, others: Sequence[float] | Real, near: float) -> bool:
    return all(abs(frequency_hz - other) > near for other in others)


def _each_line(lines: Real, records: Sequence[Real], rate_hz: float) -> Real:
    """Lines by rising frequency; of those that are one, the first that was found."""
    near = _line_width(records, rate_hz)
    taken: list[float] = []
    for line in lines:
        if _far_from_others(line, taken, near):
            taken.append(float(line))
    return np.sort(taken)


def _modes_as_arrays(modes: Sequence[ObservedMode], lines: Real) -> ResponseModes:
    value, sigma = np.array([m.value for m in modes]), np.array([m.sigma for m in modes])
    return ResponseModes(
        frequency_hz=value[:, 0] / (2 * np.pi),
        damping_ratio=value[:, 1],
        frequency_sigma_hz=sigma[:, 0] / (2 * np.pi),
        damping_sigma=sigma[:, 1],
        shapes=np.array([m.shape for m in modes]),
        shape_sigma=np.array([m.shape_sigma for m in modes]),
        confidence=np.array([m.confidence for m in modes]),
        harmonics_hz=lines,
    )


def _check_records(records: Sequence[Real], rate_hz: float, band_hz: tuple[float, float]) -> None:
    shapes = {len(r) for r in records}
    if len(shapes) != 1 or 0 in shapes:
        raise DataError(
            f"{len(records)} records of {sorted(shapes)} outputs make no set-up", remedy="give records of one set-up"
        )
    if not 0 < band_hz[0] < band_hz[1] < rate_hz / 2:
        raise DataError(
            f"the band {band_hz[0]:g} to {band_hz[1]:g} Hz does not lie between 0 and half of {rate_hz:g} Hz",
            remedy="give the lower edge first, both in Hz",
        )
    if not all(np.isfinite(r).all() for r in records) or not all(np.ptp(r, axis=1).all() for r in records):
        raise DataError("a response is not finite, or does not move", remedy="leave that channel out")


def _each_once(modes: Sequence[ObservedMode]) -> list[ObservedMode]:
    """Of poles that two bands found for one mode, the better known."""
    taken: list[ObservedMode] = []
    for mode in sorted(modes, key=lambda m: float(m.sigma[0] / m.value[0])):
        if all(abs(mode.value[0] / other.value[0] - 1) > TWICE or not shapes_agree(mode, other) for other in taken):
            taken.append(mode)
    return sorted(taken, key=lambda m: float(m.value[0]))
