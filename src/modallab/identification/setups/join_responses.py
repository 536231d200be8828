"""One set of modes of several set-ups of responses alone: sensors that stay give each set-up's shapes their scale.

Shapes of responses alone have no scale of their own, and another one in every set-up. Where some sensors stay while the
others rove, the part of a shape that they see says by which complex factor a set-up's shape is to be multiplied
(post-separate estimation re-scaling, PoSER: Reynders, Magalhaes, De Roeck, Cunha, "Merging strategies for multi-setup
operational modal analysis", IMAC XXVII, 2009; Doehler, Reynders, Magalhaes, Mevel, De Roeck and Cunha, IMAC XXVIII,
2010). Frequencies and damping ratios are averaged as those of set-ups with a force are.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError, IdentificationError
from modallab.identification.selection.pairing import SAME_MODE
from modallab.identification.setups.join import averaged

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Freedom = tuple[int, str]
"""Point and axis of a sensor."""

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
    shapes: Complex
    shape_sigma: Real


@dataclass(frozen=True, eq=False, slots=True)
class JoinedResponses:
    """The modes that all set-ups have.

    Attributes:
        places: (set-ups, modes) where each mode stands in each set-up, in the order of the set-ups.
        freedoms: (outputs,) of all set-ups.
        frequency: (2, modes) Hz, and its sigma.
        damping: (2, modes) ratio, and its sigma.
        shapes: (modes, outputs) 1 at the largest.
        shape_sigma: (modes, outputs) of the complex number.
    """

    places: NDArray[np.int64]
    freedoms: tuple[Freedom, ...]
    frequency: Real
    damping: Real
    shapes: Complex
    shape_sigma: Real


@dataclass(frozen=True, eq=False, slots=True)
class _Shapes:
    freedoms: tuple[Freedom, ...]
    values: Complex
    sigma: Real

    def of(self, freedoms: Sequence[Freedom]) -> tuple[Complex, Real]:
        at = [self.freedoms.index(f) for f in freedoms]
        return self.values[:, at], self.sigma[:, at]

    def rows(self, modes: Sequence[int]) -> "_Shapes":
        return _Shapes(self.freedoms, self.values[list(modes)], self.sigma[list(modes)])


def join_responses(found: Sequence[ResponseSetUp]) -> JoinedResponses:
    """Join set-ups that share sensors.

    Args:
        found: at least two; each shares a sensor's point and axis with one of those before it, or with a later one
            that does.

    Raises:
        DataError: nothing joins a set-up to the others.
        IdentificationError: no mode is in all set-ups.
    """
    joined = _Shapes(found[0].freedoms, found[0].shapes, found[0].shape_sigma)
    places = {0: list(range(found[0].frequency_hz.size))}
    waiting = list(range(1, len(found)))
    while waiting:
        n = next((k for k in waiting if set(found[k].freedoms) & set(joined.freedoms)), None)
        if n is None:
            raise DataError(
                f"nothing joins set-up {found[waiting[0]].name} to the others: no sensor stands where theirs do",
                remedy="leave one sensor or more at the same points in every set-up",
            )
        pairs = _partners(found[0].frequency_hz[places[0]], joined, found[n])
        if not pairs:
            raise IdentificationError(
                f"no mode of set-up {found[n].name} is in those before it",
                remedy="identify each by itself, and look at what differs",
            )
        places = {k: [of[i] for i, _ in pairs] for k, of in places.items()} | {n: [j for _, j in pairs]}
        own = _Shapes(found[n].freedoms, found[n].shapes, found[n].shape_sigma).rows([j for _, j in pairs])
        joined = _merged(joined.rows([i for i, _ in pairs]), own)
        waiting.remove(n)
    at = np.array([places[k] for k in range(len(found))], dtype=np.int64)
    shapes, sigma = _largest_one(joined)
    return JoinedResponses(
        at,
        joined.freedoms,
        _mean([s.frequency_hz for s in found], [s.frequency_sigma_hz for s in found], at),
        _mean([s.damping_ratio for s in found], [s.damping_sigma for s in found], at),
        shapes,
        sigma,
    )


def _partners(frequency_hz: Real, joined: _Shapes, item: ResponseSetUp) -> list[tuple[int, int]]:
    """Pairs of modes, the nearest in frequency first served; by rising frequency."""
    shared = [f for f in item.freedoms if f in joined.freedoms]
    here, _ = joined.of(shared)
    there = item.shapes[:, [item.freedoms.index(f) for f in shared]]
    gap = np.abs(frequency_hz[:, None] - item.frequency_hz) / frequency_hz[:, None]
    inner = np.abs(here.conj() @ there.T) ** 2
    mac = inner / np.maximum(np.outer(_power(here), _power(there)), np.finfo(float).tiny)
    # One sensor alone sees every shape alike: then the frequency decides.
    fits = (gap <= SAME_MODE) & ((mac >= ALIKE) | (len(shared) == 1))
    free_here, free_there, found = set(range(len(here))), set(range(len(there))), list[tuple[int, int]]()
    for flat in np.argsort(gap, axis=None):
        i, j = divmod(int(flat), len(there))
        if fits[i, j] and i in free_here and j in free_there:
            found.append((i, j))
            free_here.remove(i)
            free_there.remove(j)
    return sorted(found)


def _power(shapes: Complex) -> Real:
    return np.asarray(np.sum(np.abs(shapes) ** 2, axis=1), dtype=np.float64)


def _merged(joined: _Shapes, own: _Shapes) -> _Shapes:
    """Both on the scale of the first; what both know is averaged by its sigmas."""
    shared = [f for f in own.freedoms if f in joined.freedoms]
    (here, here_sigma), (there, there_sigma) = joined.of(shared), own.of(shared)
    weight = 1 / _known(here, here_sigma) ** 2
    power = np.sum(weight * np.abs(there) ** 2, axis=1)
    factor = np.sum(weight * there.conj() * here, axis=1) / power
    # Twice: how uncertain the other side is counts by the factor as well.
    weight = 1 / (_known(here, here_sigma) ** 2 + (np.abs(factor)[:, None] * _known(there, there_sigma)) ** 2)
    power = np.sum(weight * np.abs(there) ** 2, axis=1)
    factor = np.sum(weight * there.conj() * here, axis=1) / power
    factor_sigma = 1 / np.sqrt(power)
    values = factor[:, None] * own.values
    sigma = np.hypot(np.abs(factor)[:, None] * own.sigma, factor_sigma[:, None] * np.abs(own.values))
    new = [k for k, f in enumerate(own.freedoms) if f not in joined.freedoms]
    total, total_sigma = joined.values.copy(), joined.sigma.copy()
    at, of = [joined.freedoms.index(f) for f in shared], [own.freedoms.index(f) for f in shared]
    a, b = 1 / _known(total, total_sigma)[:, at] ** 2, 1 / _known(values, sigma)[:, of] ** 2
    total[:, at] = (a * total[:, at] + b * values[:, of]) / (a + b)
    total_sigma[:, at] = 1 / np.sqrt(a + b)
    return _Shapes(
        (*joined.freedoms, *(own.freedoms[k] for k in new)),
        np.concatenate([total, values[:, new]], axis=1),
        np.concatenate([total_sigma, sigma[:, new]], axis=1),
    )


def _known(values: Complex, sigma: Real) -> Real:
    """The sigma; a hundredth of the shape's rms where it is not known, or 0 as at the largest, 1 by agreement."""
    least = 0.01 * np.sqrt(np.mean(np.abs(values) ** 2, axis=-1, keepdims=True)) + np.finfo(float).tiny
    return np.where(np.isfinite(sigma) & (sigma > 0), sigma, least)


def _largest_one(joined: _Shapes) -> tuple[Complex, Real]:
    most = np.argmax(np.abs(joined.values), axis=1)[:, None]
    scale = np.take_along_axis(joined.values, most, axis=1)
    return joined.values / scale, joined.sigma / np.abs(scale)


def _mean(values: Sequence[Real], sigmas: Sequence[Real], places: NDArray[np.int64]) -> Real:
    v = np.array([value[at] for value, at in zip(values, places, strict=True)])
    s = np.array([sigma[at] for sigma, at in zip(sigmas, places, strict=True)])
    return np.array(averaged(v, np.where(np.isfinite(s) & (s > 0), s, 1e-9 * np.abs(v))))
