"""The change that leaves no mode in a band of frequencies.

A mass lowers every mode and a spring to ground raises every one, and two never cross. So each mode is in the band for
one interval of sizes at most, and the smallest size is where such an interval ends and no other one goes on.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.modification.inverse import AT_MOST, ONLY_THE_LIGHT, TRIED, By, changed_hz, deviations_of_size, modal_size
from modallab.modification.known import KnownStructure
from modallab.modification.structure import At


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
    modal_kg = min(modal_size(known.structure, r, "mass", at) for r in range(len(known.structure.poles)))
    modal = modal_kg * (1.0 if by == "mass" else (2 * np.pi * band_hz[1]) ** 2)
    # The largest holds the point still, as seen by a mode of this band.
    sizes = np.concatenate([[0.0], np.geomspace(ONLY_THE_LIGHT * modal, AT_MOST * modal, TRIED)])
    each = [changed_hz(known, by, at, size) for size in sizes]
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
            lambda size: _frequencies_of_modes(known, changed_hz(known, by, at, size), r + 1)[r] - edge,
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
