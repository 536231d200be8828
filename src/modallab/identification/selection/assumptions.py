"""What modal analysis assumes of a structure, as verdicts with numbers: the paper's four, and the driving point's sign.

Linearity (two levels), reciprocity (input and output exchanged), time invariance (first hit against last) and
proportional damping (real modal constants); at a driving point power can only flow in: Re Y >= 0.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.digits import percent_text
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.frf.distortions import Distortions
from modallab.frf.estimate import convert_frf
from modallab.frf.undriven_lines import UndrivenDistortions
from modallab.identification.selection.criteria import mpd

Assumption = Literal["linearity", "time invariance", "reciprocity", "proportional damping", "driving point"]

CHANGE_LIMIT = 0.05
"""Share by which two FRFs of one structure may differ: mounting, position and direction of a sensor do as much."""
PHASE_LIMIT_RAD = 0.1
SIGMAS = 3.0
MOST_CHANGE = 0.5
"""Above this limit no structure could fail: noise this large leaves the assumption open."""
MOST_PHASE_RAD = 0.5
"""The same of the phases, of which the mean deviation is 0.8 where they say nothing at all."""
LEAST_LINES = 0.2
"""Share of a driving point's lines that must stand above their noise, or its power flow is not known."""
CANNOT_BE_SAID = "cannot be said from these data"


@dataclass(frozen=True, slots=True)
class AssumptionVerdict:
    """One assumption: whether it holds, the number that says so, its limit, and both in words."""

    assumption: Assumption
    holds: bool
    value: float
    limit: float
    words: str


@dataclass(frozen=True, slots=True)
class AllowedDifference:
    """By what share two FRFs of one structure may differ since a bench is no better than its tolerances.

    Attributes:
        share: three standard deviations.
        why: in words, to be read after "are allowed".
    """

    share: float = CHANGE_LIMIT
    why: str = ""


USUAL = AllowedDifference()


def linearity(low: Frf, high: Frf, allowed: AllowedDifference = USUAL) -> AssumptionVerdict:
    """FRFs of two drive levels: for a linear structure they are one.

    Raises:
        DataError: the two are not FRFs of the same outputs, inputs and lines, or noise leaves it open.
    """
    return _unchanged_verdict("linearity", low, high, "The FRFs of the two levels", allowed)


def linearity_of_waves(found: Distortions | UndrivenDistortions) -> AssumptionVerdict:
    """What a linear structure does not do: answer other lines than the driven ones, or wave by wave otherwise.

    Raises:
        DataError: noise hides as much as is allowed.
    """
    level, noise = float(np.max(found.level)), float(np.max(found.noise_level)) / np.sqrt(found.periods * found.waves)
    if noise > CHANGE_LIMIT:
        raise DataError(f"{CANNOT_BE_SAID}: noise of {percent_text(noise)} hides what is allowed")
    if isinstance(found, UndrivenDistortions):
        most = int(np.argmax(found.level))
        words = (
            f"Beyond noise, at most {percent_text(level)} of a response is distortion, by lines that the drive leaves"
            f" out: odd {_percent_with_sigma(found.odd[most], found.odd_sigma[most])} %, even "
            f"{_percent_with_sigma(found.even[most], found.even_sigma[most])} %"
        )
    else:
        what = "What changes from one random wave to the next, beyond noise,"
        words = f"{what} is at most {percent_text(level)} of a response"
    allowed = f"; up to {percent_text(CHANGE_LIMIT)} is allowed."
    return AssumptionVerdict("linearity", level <= CHANGE_LIMIT, level, CHANGE_LIMIT, words + allowed)


def _percent_with_sigma(share: float, sigma: float) -> str:
    return f"{100 * share:.2g} ± {100 * sigma:.1g}"


def time_invariance(first: Frf, last: Frf, allowed: AllowedDifference = USUAL) -> AssumptionVerdict:
    """FRFs from the first and from the last blocks of a test.

    Raises:
        DataError: as for `linearity`.
    """
    return _unchanged_verdict("time invariance", first, last, "The first and the last FRFs", allowed)


def reciprocity(frf: Frf, allowed: AllowedDifference = USUAL) -> AssumptionVerdict:
    """H_jk against H_kj, the worst pair of points at which there is both a sensor and a hit.

    Raises:
        DataError: no such pair; or no FRF.
    """
    values = convert_frf(frf, frf.quantity).values
    shared = [p for p in frf.input_points if p is not None and p in frf.output_points]
    place = [(frf.output_points.index(p), frf.input_points.index(p)) for p in shared]
    pairs = [(a, b) for i, a in enumerate(place) for b in place[:i]]
    if not pairs:
        raise DataError(
            f"no two of the driven points {list(frf.input_points)} hold a sensor",
            remedy="hit at two points where sensors stand",
        )
    away = [_rms_difference(values[a[0], b[1]], values[b[0], a[1]]) for a, b in pairs]
    noise = [_expected_difference(frf, a, b) for a, b in pairs]
    worst = int(np.argmax(np.array(away) - SIGMAS * np.array(noise)))
    return _verdict_on_difference(
        "reciprocity", away[worst], noise[worst], "FRFs with input and output exchanged", allowed
    )


def proportional_damping(model: ModalModel) -> AssumptionVerdict:
    """The modal constants' mean phase deviation from a line, the worst mode: zero for proportional damping.

    Raises:
        DataError: fewer than two outputs, no mode, or noise that leaves it open.
    """
    modes, outputs, _ = model.modal_constants.shape
    if modes == 0 or outputs < 2:
        raise DataError(
            f"{modes} modes at {outputs} outputs have no phases to compare", remedy="use two sensors or more"
        )
    size = np.abs(model.modal_constants)
    best = np.argmax(np.sum(size, axis=1), axis=1)
    columns = np.stack([model.modal_constants[r, :, k] for r, k in enumerate(best)])
    parts = model.modal_constant_part_sigma
    of_parts = model.modal_constant_sigma * (1 + 1j) / np.sqrt(2) if parts is None else parts
    sigma = _sigma_across(columns, np.stack([of_parts[r, :, k] for r, k in enumerate(best)]))
    deviation = mpd(columns)
    # |A| dphi = sigma for each point; the mean of absolute values of a normal number is sqrt(2 / pi) of it.
    noise = np.sum(np.nan_to_num(sigma), axis=1) / np.sum(np.abs(columns), axis=1) * np.sqrt(2 / np.pi)
    limits = np.maximum(PHASE_LIMIT_RAD, SIGMAS * noise)
    worst = int(np.argmax(deviation - limits))
    value, limit = float(deviation[worst]), float(limits[worst])
    _require_a_limit(
        value, limit, MOST_PHASE_RAD, f"noise alone changes the phases of a mode by {np.degrees(limit):.2g} degrees"
    )
    words = (
        f"The points of mode {worst + 1} ({model.frequency_hz[worst]:.4g} Hz) move {np.degrees(value):.2g} degrees out "
        f"of phase on average; up to {np.degrees(limit):.2g} degrees is allowed."
    )
    return AssumptionVerdict("proportional damping", value <= limit, value, limit, words)


def _sigma_across(values: NDArray[np.complex128], of_parts: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Sigma of complex numbers across their own direction, from that of their real and imaginary parts."""
    turn = np.angle(values)
    return np.hypot(np.sin(turn) * of_parts.real, np.cos(turn) * of_parts.imag)


def driving_point(frf: Frf) -> AssumptionVerdict:
    """Share of the driving points' lines where Re of mobility is below zero by more than its noise.

    A turned sensor, a sensor on another spot or a delay between the channels does that; noise alone rarely.

    Raises:
        DataError: no sensor at a driven point, noise that leaves it open, or no FRF.
    """
    mobility = convert_frf(frf, "mobility")
    pairs = [
        (frf.output_points.index(p), k)
        for k, p in enumerate(frf.input_points)
        if p is not None and p in frf.output_points
    ]
    if not pairs:
        raise DataError("no sensor stands at a driven point", remedy="put one there")
    shares: list[float] = []
    known: list[float] = []
    for o, i in pairs:
        value = mobility.values[o, i]
        variance = np.zeros(value.size) if mobility.variance is None else mobility.variance[o, i]
        least = np.maximum(SIGMAS * np.sqrt(variance / 2), 1e-3 * np.abs(value).max())
        shares.append(float(np.mean(value.real < -least)))
        known.append(float(np.mean(np.abs(value) > least)))
    worst = max(shares)
    if worst <= CHANGE_LIMIT and max(known) < LEAST_LINES:
        raise _unjudged(f"{percent_text(max(known))} of the driving point's lines stand out of the noise")
    words = (
        "The real part of a driving-point mobility, which no passive structure can make negative, is negative at "
        f"{percent_text(worst)} of the lines; up to {percent_text(CHANGE_LIMIT)} is allowed."
    )
    return AssumptionVerdict("driving point", worst <= CHANGE_LIMIT, worst, CHANGE_LIMIT, words)


def _unchanged_verdict(
    assumption: Assumption, one: Frf, other: Frf, subject: str, allowed: AllowedDifference
) -> AssumptionVerdict:
    a, b = convert_frf(one, one.quantity), convert_frf(other, one.quantity)
    same = a.values.shape == b.values.shape and np.allclose(a.frequency_hz, b.frequency_hz, rtol=1e-6)
    if not same or a.outputs != b.outputs or a.input_points != b.input_points:
        raise DataError(
            f"FRFs of shapes {a.values.shape} and {b.values.shape} are not of one set-up",
            remedy="give the same outputs, inputs and lines of both",
        )
    parts = [(_rms_difference(x, y), _noise_of(a, b, o, i)) for (o, i, x, y) in _each_difference(a.values, b.values)]
    worst = max(parts, key=lambda p: p[0] - SIGMAS * p[1])
    return _verdict_on_difference(assumption, worst[0], worst[1], subject, allowed)


def _each_difference(
    a: NDArray[np.complex128], b: NDArray[np.complex128]
) -> list[tuple[int, int, NDArray[np.complex128], NDArray[np.complex128]]]:
    return [(o, i, a[o, i], b[o, i]) for o in range(a.shape[0]) for i in range(a.shape[1])]


def _rms_difference(x: NDArray[np.complex128], y: NDArray[np.complex128]) -> float:
    """RMS of the difference as a share of the RMS of the mean."""
    level = np.sqrt(np.mean(np.abs(x + y) ** 2)) / 2
    return float(np.sqrt(np.mean(np.abs(x - y) ** 2)) / level) if level > 0 else float("inf")


def _noise_of(a: Frf, b: Frf, o: int, i: int) -> float:
    if a.variance is None or b.variance is None:
        return 0.0
    level = np.mean(np.abs(a.values[o, i] + b.values[o, i]) ** 2) / 4
    return float(np.sqrt(np.mean(a.variance[o, i] + b.variance[o, i]) / level))


def _expected_difference(frf: Frf, a: tuple[int, int], b: tuple[int, int]) -> float:
    if frf.variance is None:
        return 0.0
    x, y = frf.values[a[0], b[1]], frf.values[b[0], a[1]]
    level = np.mean(np.abs(x + y) ** 2) / 4
    return float(np.sqrt(np.mean(frf.variance[a[0], b[1]] + frf.variance[b[0], a[1]]) / level))


def _verdict_on_difference(
    assumption: Assumption, value: float, noise: float, subject: str, allowed: AllowedDifference
) -> AssumptionVerdict:
    least = max(CHANGE_LIMIT, allowed.share)
    limit = max(least, SIGMAS * noise)
    _require_a_limit(
        value, limit, MOST_CHANGE, f"noise alone makes the FRFs differ by {percent_text(limit)} of their level"
    )
    why = f", {allowed.why}" if allowed.why and limit == allowed.share else ""
    words = f"{subject} differ by at most {percent_text(value)}; up to {percent_text(limit)} is allowed{why}."
    return AssumptionVerdict(assumption, value <= limit, value, limit, words)


def _require_a_limit(value: float, limit: float, most: float, why: str) -> None:
    """Reject a verdict that could not have come out otherwise."""
    if value <= limit and not limit <= most:
        raise _unjudged(why)


def _unjudged(why: str) -> DataError:
    return DataError(f"{CANNOT_BE_SAID}: {why}", remedy="hit or drive harder, or average more blocks")
