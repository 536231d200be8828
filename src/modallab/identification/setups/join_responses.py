"""One set of modes of several set-ups of responses alone: sensors that stay give each set-up's shapes their scale.

Shapes of responses alone have no scale of their own, and another one in every set-up. Where some sensors stay while the
others rove, the part of a shape that they see says by which complex factor a set-up's shape is to be multiplied
(post-separate estimation re-scaling, PoSER: Reynders, Magalhaes, De Roeck, Cunha, "Merging strategies for multi-setup
operational modal analysis", IMAC XXVII, 2009; Doehler, Reynders, Magalhaes, Mevel, De Roeck and Cunha, IMAC XXVIII,
2010). Frequencies and damping ratios are averaged as those of set-ups with a force are.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError, IdentificationError
from modallab.identification.selection.criteria import SAME_MODE
from modallab.identification.setups.join import weighted_mean

Freedom = tuple[int, str]
"""Point and axis of a sensor."""

Look = Callable[[int, Real, Real], tuple[Complex128, Real]]
"""What the records of a set-up hold at all modes' frequencies in Hz and damping ratios: shapes (modes, outputs) of any
scale, and their sigmas."""

MOST = 0.5
"""A mode found in more than this share of the set-ups is one of the structure."""
ALIKE = 0.8
"""Modes of two set-ups are one if the sensors that stay see shapes of at least this MAC."""


@dataclass(frozen=True, eq=False, slots=True)
class ResponseSetUp:
    """What one set-up of responses alone gave.

    Attributes:
        name: of the set-up.
        freedoms: (outputs,) each once.
        frequency_hz: (modes,)
        frequency_sigma_hz: (modes,)
        damping_ratio: (modes,)
        damping_sigma: (modes,)
        shapes: (modes, outputs) of any scale.
        shape_sigma: (modes, outputs) of the complex number.
    """

    name: str
    freedoms: tuple[Freedom, ...]
    frequency_hz: Real
    frequency_sigma_hz: Real
    damping_ratio: Real
    damping_sigma: Real
    shapes: Complex128
    shape_sigma: Real


@dataclass(frozen=True, eq=False, slots=True)
class JoinedResponses:
    """The modes that most set-ups have, by rising frequency.

    Attributes:
        places: (set-ups, modes) where each mode stands in each set-up, in the order of the set-ups; -1 where it was not
            found.
        freedoms: (outputs,) of all set-ups.
        frequency: (2, modes) Hz, and its sigma.
        damping: (2, modes) ratio, and its sigma.
        shapes: (modes, outputs) 1 at the largest; 0 where nothing is known.
        shape_sigma: (modes, outputs) of the complex number; NaN where nothing is known.
    """

    places: NDArray[np.int64]
    freedoms: tuple[Freedom, ...]
    frequency: Real
    damping: Real
    shapes: Complex128
    shape_sigma: Real


@dataclass(frozen=True, eq=False, slots=True)
class _PartialShapes:
    """Shapes (modes, outputs) of which some components are not known: their sigma is infinite."""

    freedoms: tuple[Freedom, ...]
    values: Complex128
    sigma: Real

    def of(self, freedoms: Sequence[Freedom]) -> tuple[Complex128, Real]:
        at = [self.freedoms.index(f) for f in freedoms]
        return self.values[:, at], self.sigma[:, at]

    def rows(self, modes: NDArray[np.int64]) -> "_PartialShapes":
        """Those of these modes; of -1 nothing is known."""
        known = modes[:, None] >= 0
        return _PartialShapes(
            self.freedoms, np.where(known, self.values[modes], 0), np.where(known, self.sigma[modes], np.inf)
        )


def join_responses(found: Sequence[ResponseSetUp], look: Look | None = None) -> JoinedResponses:
    """Join set-ups that share sensors.

    A set-up by itself finds a mode of few periods or misses it by chance. What most of them found is a mode, and the
    records of the others are asked again, at its frequency and damping.

    Args:
        found: at least two; each shares a sensor's point and axis with one of those before it, or with a later one
            that does.
        look: what a set-up's records hold of all modes; None to leave unknown what a set-up did not find.

    Raises:
        DataError: nothing joins a set-up to the others.
        IdentificationError: a set-up has no mode of the others, or no mode is in most of them.
    """
    joined = _of_set_up(found[0])
    places = np.full((len(found), found[0].frequency_hz.size), -1, np.int64)
    places[0] = np.arange(places.shape[1])
    waiting = list(range(1, len(found)))
    while waiting:
        n = next((k for k in waiting if set(found[k].freedoms) & set(joined.freedoms)), None)
        if n is None:
            raise DataError(
                f"nothing joins set-up {found[waiting[0]].name} to the others: no sensor stands where theirs do",
                remedy="leave one sensor or more at the same points in every set-up",
            )
        places = _place_modes(places, _pair_modes(_median_frequency(found, places), joined, found[n]), n, found[n])
        joined = _merge_shapes(joined.rows(_rows_before(joined, places)), _of_set_up(found[n]).rows(places[n]))
        waiting.remove(n)
    most = np.flatnonzero(np.count_nonzero(places >= 0, axis=0) > MOST * len(found))
    if not most.size:
        raise IdentificationError(
            f"no mode is in most of the set-ups {', '.join(item.name for item in found)}",
            remedy="identify each by itself, and look at what differs",
        )
    most = most[np.argsort(_median_frequency(found, places)[most])]
    return _join_setup(found, joined.rows(most), places[:, most], look)


def _join_setup(
    found: Sequence[ResponseSetUp], joined: _PartialShapes, places: NDArray[np.int64], look: Look | None
) -> JoinedResponses:
    frequency = _mean_of_setups([s.frequency_hz for s in found], [s.frequency_sigma_hz for s in found], places)
    damping = _mean_of_setups([s.damping_ratio for s in found], [s.damping_sigma for s in found], places)
    for n in np.flatnonzero((places < 0).any(axis=1)).tolist() if look else []:
        assert look is not None
        lacking = places[n] < 0
        values, sigma = look(n, frequency[0], damping[0])
        asked = np.where(lacking, np.arange(lacking.size), -1)
        joined = _merge_shapes(joined, _PartialShapes(found[n].freedoms, values, sigma).rows(asked))
    shapes, sigma = _largest_one(joined)
    return JoinedResponses(
        places, joined.freedoms, frequency, damping, shapes, np.where(np.isinf(sigma), np.nan, sigma)
    )


def _of_set_up(item: ResponseSetUp) -> _PartialShapes:
    return _PartialShapes(item.freedoms, item.shapes, _known_sigma(item.shapes, item.shape_sigma))


def _median_frequency(found: Sequence[ResponseSetUp], places: NDArray[np.int64]) -> Real:
    """(modes,) Hz, the median over the set-ups that have each."""
    hz = np.array([np.where(at >= 0, item.frequency_hz[at], np.nan) for item, at in zip(found, places, strict=True)])
    return np.asarray(np.nanmedian(hz, axis=0), np.float64)


def _place_modes(
    places: NDArray[np.int64], pairs: Sequence[tuple[int, int]], n: int, item: ResponseSetUp
) -> NDArray[np.int64]:
    """Places with those of set-up n, and with the modes that it alone has so far behind the others."""
    if not pairs:
        raise IdentificationError(
            f"no mode of set-up {item.name} is in those before it",
            remedy="identify each by itself, and look at what differs",
        )
    taken = {j for _, j in pairs}
    new = [j for j in range(item.frequency_hz.size) if j not in taken]
    places = np.concatenate([places, np.full((len(places), len(new)), -1)], axis=1)
    for i, j in (*pairs, *zip(range(places.shape[1] - len(new), places.shape[1]), new, strict=True)):
        places[n, i] = j
    return places


def _rows_before(joined: _PartialShapes, places: NDArray[np.int64]) -> NDArray[np.int64]:
    """(modes,) rows of what was joined before, -1 for the modes that are new."""
    rows = np.arange(places.shape[1])
    return np.where(rows < len(joined.values), rows, -1)


def _pair_modes(frequency_hz: Real, joined: _PartialShapes, item: ResponseSetUp) -> list[tuple[int, int]]:
    """Pairs of modes, the nearest in frequency first served; by rising frequency."""
    shared = [f for f in item.freedoms if f in joined.freedoms]
    here, sigma = joined.of(shared)
    there = item.shapes[:, [item.freedoms.index(f) for f in shared]]
    known = np.isfinite(sigma)
    gap = np.abs(frequency_hz[:, None] - item.frequency_hz) / frequency_hz[:, None]
    inner = np.abs((here * known).conj() @ there.T) ** 2
    powers = _power_of_shapes(here * known)[:, None] * (known @ (np.abs(there) ** 2).T)
    mac = inner / np.maximum(powers, np.finfo(float).tiny)
    # One sensor alone sees every shape alike: then the frequency decides.
    fits = (gap <= SAME_MODE) & ((mac >= ALIKE) | (np.count_nonzero(known, axis=1) < 2)[:, None])
    free_here, free_there, found = set(range(len(here))), set(range(len(there))), list[tuple[int, int]]()
    for flat in np.argsort(gap, axis=None):
        i, j = divmod(int(flat), len(there))
        if fits[i, j] and i in free_here and j in free_there:
            found.append((i, j))
            free_here.remove(i)
            free_there.remove(j)
    return sorted(found)


def _power_of_shapes(shapes: Complex128) -> Real:
    return np.asarray(np.sum(np.abs(shapes) ** 2, axis=1), dtype=np.float64)


def _merge_shapes(joined: _PartialShapes, own: _PartialShapes) -> _PartialShapes:
    """Both on the scale of the first; what both know is averaged by its sigmas."""
    shared = [f for f in own.freedoms if f in joined.freedoms]
    (here, here_sigma), (there, there_sigma) = joined.of(shared), own.of(shared)
    factor, factor_sigma = _scale_factor(here, there, here_sigma)
    # Twice: how uncertain the other side is counts by the factor as well.
    factor, factor_sigma = _scale_factor(here, there, np.hypot(here_sigma, _scale_sigmas(there_sigma, factor)))
    alone = np.isinf(joined.sigma).all(axis=1)
    factor, factor_sigma = np.where(alone, 1.0, factor), np.where(alone, 0.0, factor_sigma)
    values = factor[:, None] * own.values
    of_factor = np.where(np.isinf(factor_sigma)[:, None], np.inf, _scale_sigmas(np.abs(own.values), factor_sigma))
    sigma = np.hypot(_scale_sigmas(own.sigma, factor), of_factor)
    new = [k for k, f in enumerate(own.freedoms) if f not in joined.freedoms]
    total, total_sigma = joined.values.copy(), joined.sigma.copy()
    at, of = [joined.freedoms.index(f) for f in shared], [own.freedoms.index(f) for f in shared]
    a, b = 1 / total_sigma[:, at] ** 2, 1 / sigma[:, of] ** 2
    weight = np.maximum(a + b, np.finfo(float).tiny)
    total[:, at] = (a * total[:, at] + b * values[:, of]) / weight
    total_sigma[:, at] = np.where(a + b > 0, 1 / np.sqrt(weight), np.inf)
    return _PartialShapes(
        (*joined.freedoms, *(own.freedoms[k] for k in new)),
        np.concatenate([total, values[:, new]], axis=1),
        np.concatenate([total_sigma, sigma[:, new]], axis=1),
    )


def _scale_factor(here: Complex128, there: Complex128, sigma: Real) -> tuple[Complex128, Real]:
    """(modes,) by which the one is the other, by least squares, and its sigma: 0 and infinite if unknown."""
    weight = 1 / sigma**2
    power = np.sum(weight * np.abs(there) ** 2, axis=1)
    safe = np.where(power > 0, power, 1.0)
    factor = np.sum(weight * there.conj() * here, axis=1) / safe
    return factor, np.where(power > 0, 1 / np.sqrt(safe), np.inf)


def _scale_sigmas(sigma: Real, factor: Complex128 | Real) -> Real:
    """Sigmas (modes, outputs) times a factor of each mode; what is not known stays so."""
    known, times = np.isfinite(sigma), np.where(np.isfinite(factor), np.abs(factor), 0.0)
    return np.where(known, np.where(known, sigma, 0.0) * times[:, None], np.inf)


def _known_sigma(values: Complex128, sigma: Real) -> Real:
    """The sigma; a hundredth of the shape's rms where it is not known, or 0 as at the largest, 1 by agreement."""
    least = 0.01 * np.sqrt(np.mean(np.abs(values) ** 2, axis=-1, keepdims=True)) + np.finfo(float).tiny
    return np.where(np.isfinite(sigma) & (sigma > 0), sigma, least)


def _largest_one(joined: _PartialShapes) -> tuple[Complex128, Real]:
    most = np.argmax(np.abs(joined.values), axis=1)[:, None]
    scale = np.take_along_axis(joined.values, most, axis=1)
    return joined.values / scale, joined.sigma / np.abs(scale)


def _mean_of_setups(values: Sequence[Real], sigmas: Sequence[Real], places: NDArray[np.int64]) -> Real:
    v = np.array([value[at] for value, at in zip(values, places, strict=True)])
    s = np.array([sigma[at] for sigma, at in zip(sigmas, places, strict=True)])
    s = np.where(np.isfinite(s) & (s > 0), s, 1e-9 * np.abs(v))
    return np.array(weighted_mean(v, np.where(places >= 0, s, np.inf)))
