"""The change that a wanted property needs: a frequency of a mode, or the least motion at a resonance.

A mass lowers every mode and a spring to ground raises every one, and two never cross. So each mode is in the band for
one interval of sizes at most, and the smallest size is where such an interval ends and no other one goes on.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from scipy.optimize import brentq, minimize

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.modification.attachments import AttachedPart, Element, TunedAbsorber
from modallab.modification.known import KnownStructure
from modallab.modification.poles import StructureWithAttachments, poles_of
from modallab.modification.structure import At, Structure

By = Literal["mass", "spring"]

TRIED = 60
"""Sizes at each point, evenly over the logarithm; between two of them a frequency moves one way."""
ONLY_THE_LIGHT = 1e-3
"""Of the modal mass or stiffness: the smallest size that is tried."""
AT_MOST = 30.0
"""Times the modal mass or stiffness at the point: more hardly moves a mode any further."""


@dataclass(frozen=True, slots=True)
class ChangeAtPoint:
    """A change at a point that brings a mode to a frequency, or why there is none.

    Attributes:
        at: the point.
        size: kg or N/m; NaN where there is none.
        sigma: of the size, one standard deviation.
        hz_sigma: of the frequency that it gives, Hz.
        lowest_hz: of the frequencies that any size reaches there.
        highest_hz: of them.
    """

    at: At
    size: float
    sigma: float
    hz_sigma: float
    lowest_hz: float
    highest_hz: float

    @property
    def feasible(self) -> bool:
        """Whether there is one."""
        return bool(np.isfinite(self.size))


class BestAbsorber(NamedTuple):
    """An absorber, its mass over the modal mass at its point, and the largest mobility there about the mode.

    Peaks are in m/(N s), with one standard deviation.
    """

    absorber: TunedAbsorber
    mass_ratio: float
    before: float
    after: float
    before_sigma: float
    after_sigma: float


def changes_for_frequency(
    known: KnownStructure, mode: int, to_hz: float, by: By, at: Sequence[At]
) -> tuple[ChangeAtPoint, ...]:
    """What brings a mode to a frequency, at each of several points; the smallest first, then the points without one.

    Args:
        known: the structure.
        mode: from 1.
        to_hz: Hz.
        by: a mass, or a spring to ground.
        at: points to try.

    Raises:
        DataError: no such mode, or a frequency beyond the band.
    """
    modes = len(known.structure.poles)
    if not 1 <= mode <= modes:
        raise DataError(f"there is no mode {mode}", remedy=f"name one from 1 to {modes}")
    if not 0 < to_hz < known.model.band_hz[1]:
        raise DataError(f"{to_hz:g} Hz is outside the band", remedy=f"stay below {known.model.band_hz[1]:.4g} Hz")
    found = [_change_at_point(known, mode - 1, to_hz, by, point) for point in at]
    return tuple(sorted(found, key=lambda a: (not a.feasible, a.size if a.feasible else 0.0)))


def _change_at_point(known: KnownStructure, mode: int, to_hz: float, by: By, at: At) -> ChangeAtPoint:
    pole, modal = known.structure.poles[mode], modal_mass_or_stiffness(known.structure, mode, by, at)
    sizes = np.geomspace(ONLY_THE_LIGHT * modal, AT_MOST * modal, TRIED)
    hz = np.array([frequencies_after_change(known, by, at, size)[mode] for size in sizes])
    start = float(np.abs(pole)) / (2 * np.pi)
    # No mass raises a mode and no spring to ground lowers one (Rayleigh, Theory of Sound (1877), section 88).
    hz = np.minimum(hz, start) if by == "mass" else np.maximum(hz, start)
    reached = float(min(start, hz.min())), float(max(start, hz.max()))
    between = np.flatnonzero((hz[:-1] - to_hz) * (hz[1:] - to_hz) <= 0)
    first = (start - to_hz) * (hz[0] - to_hz) <= 0
    if not between.size and not first:
        return ChangeAtPoint(at, np.nan, np.nan, np.nan, *reached)
    low, high = (1e-3 * sizes[0], sizes[0]) if first else sizes[between[0] : between[0] + 2]

    def off(log_size: float) -> float:
        return float(frequencies_after_change(known, by, at, float(np.exp(log_size)))[mode]) - to_hz

    size = float(np.exp(brentq(off, np.log(low), np.log(high), xtol=1e-9)))
    return ChangeAtPoint(at, size, *deviations_of_size(known, to_hz, by, at, size), *reached)


def modal_mass_or_stiffness(whole: Structure, mode: int, by: By, at: At) -> float:
    """Modal mass or stiffness of a mode, from 0, at a point, kg or N/m."""
    place, pole = whole.index(at), whole.poles[mode]
    phi2 = np.abs(whole.psi[mode] ** 2 * 2 * pole.imag)
    # A point near a node needs more than any point has: the largest shape bounds what is tried there.
    return (1.0 if by == "mass" else float(np.abs(pole) ** 2)) / float(max(phi2[place], 1e-3 * phi2.max()))


def frequencies_after_change(known: KnownStructure, by: By, at: At, size: float) -> Real:
    """(modes,) with a change. A mode keeps its place as the change grows: two never cross."""
    changes = [element_of_kind(by, at, size)] if size else []
    return np.sort(np.abs(poles_of(StructureWithAttachments.of(known.structure, changes)))) / (2 * np.pi)


def element_of_kind(by: By, at: At, size: float) -> Element:
    """A mass, or a spring to ground; a DataError if it is to be neither."""
    if by not in get_args(By):
        raise DataError(f"by={by!r} is not a kind of change", remedy=f"use one of {', '.join(get_args(By))}")
    return Element(at, mass=size) if by == "mass" else Element(at, spring=size)


def deviations_of_size(known: KnownStructure, to_hz: float, by: By, at: At, size: float) -> tuple[float, float]:
    """Of a size and of the frequency it gives: the one is the other over how the frequency moves with the size."""
    small = 1e-3 * size
    here, there = (known.with_changes([element_of_kind(by, at, s)]).modes for s in (size, size + small))
    r = int(np.argmin(np.abs(here.frequency_hz - to_hz)))
    slope = (there.frequency_hz[r] - here.frequency_hz[r]) / small
    return float(here.frequency_sigma_hz[r] / abs(slope)), float(here.frequency_sigma_hz[r])


def best_absorber(known: KnownStructure, mode: int, at: At, mass: float) -> BestAbsorber:
    """The absorber that leaves the least peak of the driving-point mobility about a mode.

    Den Hartog's tuning of a structure of one mode begins the search; the others, and its own damping, then move it.

    Args:
        known: the structure.
        mode: from 1.
        at: where the absorber hangs.
        mass: of it, kg.

    Raises:
        DataError: no such mode, or the mode has a node there.
    """
    if not 1 <= mode <= len(known.structure.poles):
        raise DataError(f"there is no mode {mode}", remedy=f"name one from 1 to {len(known.structure.poles)}")
    ratio, omega = _mass_ratio(known, mode - 1, at, mass)
    TunedAbsorber(at, mass, omega / (2 * np.pi))  # rejects a mass that is none
    f = omega / (2 * np.pi) * np.linspace(0.5, 1.5, 1001)
    start = np.log([1 / (1 + ratio), np.sqrt(3 * ratio / (8 * (1 + ratio)))])

    def peak(x: Real) -> float:
        absorber = TunedAbsorber(at, mass, float(omega / (2 * np.pi) * np.exp(x[0])), float(np.exp(x[1])))
        return _largest_peak(known, [absorber], f, at)

    found: Any = minimize(peak, start, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-9})
    best = TunedAbsorber(at, mass, float(omega / (2 * np.pi) * np.exp(found.x[0])), float(np.exp(found.x[1])))

    def peaks(one: KnownStructure) -> Real:
        return np.array([_largest_peak(one, changes, f, at) for changes in ([], [best])])

    return BestAbsorber(best, ratio, *peaks(known).tolist(), *known.standard_deviation(peaks).tolist())


def _mass_ratio(known: KnownStructure, mode: int, at: At, mass: float) -> tuple[float, float]:
    whole = known.structure
    pole, place = whole.poles[mode], whole.index(at)
    phi2 = np.abs(whole.psi[mode] ** 2 * 2 * pole.imag)
    if phi2[place] < 1e-4 * phi2.max():
        raise DataError(f"mode {mode + 1} has a node at {at}", remedy="hang the absorber where the mode moves")
    return float(mass * phi2[place]), float(np.abs(pole))


def _largest_peak(known: KnownStructure, changes: Sequence[AttachedPart], f: Real, at: At) -> float:
    b = known.structure.unit_vectors([at])
    s = np.asarray(2j * np.pi * f)
    return float(np.max(np.abs(s * StructureWithAttachments.of(known.structure, changes).receptance(s, b, b)[:, 0, 0])))


@dataclass(frozen=True, slots=True)
class FreeBand:
    """A change at a point that leaves no mode in a band, or why there is none.

    Attributes:
        at: the point.
        size: kg or N/m; 0 where the band is free already, NaN where there is none.
        sigma: of the size, one standard deviation.
        up_to: size from which the next mode is in the band; infinite where none comes.
        stays: the mode, from 1, that is in the band at the largest size that was tried; 0 where there is an answer.
        stays_hz: where that mode is then.
    """

    at: At
    size: float
    sigma: float
    up_to: float
    stays: int = 0
    stays_hz: float = np.nan

    @property
    def feasible(self) -> bool:
        """Whether there is one."""
        return bool(np.isfinite(self.size))


def changes_for_free_band(
    known: KnownStructure, band_hz: tuple[float, float], by: By, at: Sequence[At]
) -> tuple[FreeBand, ...]:
    """What leaves no mode in a band, at each of several points; the smallest first, then the points without one.

    Args:
        known: the structure.
        band_hz: lower and upper edge.
        by: a mass, or a spring to ground.
        at: points to try.

    Raises:
        DataError: edges that do not rise or lie beyond the model's band, or a point that the model does not know.
    """
    low, high = band_hz
    if not 0 < low < high < known.model.band_hz[1]:
        raise DataError(
            f"no band from {low:g} to {high:g} Hz can be kept free",
            remedy=f"give a lower and an upper edge below {known.model.band_hz[1]:.4g} Hz, where the model ends",
        )
    found = [_free_band_at_point(known, band_hz, by, point) for point in at]
    return tuple(sorted(found, key=lambda a: (not a.feasible, a.size if a.feasible else 0.0)))


def _free_band_at_point(known: KnownStructure, band_hz: tuple[float, float], by: By, at: At) -> FreeBand:
    modal_kg = min(modal_mass_or_stiffness(known.structure, r, "mass", at) for r in range(len(known.structure.poles)))
    modal = modal_kg * (1.0 if by == "mass" else (2 * np.pi * band_hz[1]) ** 2)
    # The largest holds the point still, as seen by a mode of this band.
    sizes = np.concatenate([[0.0], np.geomspace(ONLY_THE_LIGHT * modal, AT_MOST * modal, TRIED)])
    each = [frequencies_after_change(known, by, at, size) for size in sizes]
    # A heavy mass may bring in a mode from beyond the band.
    modes = max(found.size for found in each)
    hz = np.array([_frequencies_of_modes(known, found, modes) for found in each])
    busy = [_sizes_in_band(known, band_hz, by, at, sizes, hz[:, r], r) for r in range(hz.shape[1])]
    spans = [span for span in busy if span is not None]
    ends = [0.0, *(end for _, end in spans if np.isfinite(end))]
    free = [end for end in sorted(ends) if not any(begin <= end < other for begin, other in spans)]
    if not free:
        r = next(r for r, span in enumerate(busy) if span and span[1] == np.inf)
        return FreeBand(at, np.nan, np.nan, np.nan, r + 1, float(hz[-1, r]))
    size = free[0]
    edge = band_hz[0] if by == "mass" else band_hz[1]
    sigma = deviations_of_size(known, edge, by, at, size)[0] if size else 0.0
    return FreeBand(at, size, sigma, min((begin for begin, _ in spans if begin > size), default=np.inf))


def _frequencies_of_modes(known: KnownStructure, hz: Real, modes: int) -> Real:
    """(modes,) frequencies; at the end of the model's band where a mode is not in it."""
    found = hz[:modes]
    return np.pad(found, (0, modes - found.size), constant_values=known.model.band_hz[1])


def _sizes_in_band(
    known: KnownStructure, band_hz: tuple[float, float], by: By, at: At, sizes: Real, hz: Real, r: int
) -> tuple[float, float] | None:
    """Sizes from which and up to which a mode is in the band."""
    first, last = band_hz if by == "spring" else band_hz[::-1]

    def reached(edge: float) -> float:
        return _zero_crossing(
            lambda size: _frequencies_of_modes(known, frequencies_after_change(known, by, at, size), r + 1)[r] - edge,
            sizes,
            hz - edge,
        )

    begin = 0.0 if (hz[0] - first) * (last - first) >= 0 else reached(first)
    end = 0.0 if (hz[0] - last) * (last - first) > 0 else reached(last)
    return (begin, end) if end > begin else None


def _zero_crossing(off: Callable[[float], Any], sizes: Real, there: Real) -> float:
    """The size at which what is off goes through zero; infinite where it does not."""
    between = np.flatnonzero(there[:-1] * there[1:] <= 0)
    if not between.size:
        return float(np.inf)
    return float(brentq(off, sizes[between[0]], sizes[between[0] + 1], rtol=1e-9))
