"""Poles of one band at many orders and block sizes, gathered into modes, and how well each is known."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from scipy.special import ndtri, stdtrit

from modallab.core.arrays import Complex128, Real
from modallab.identification.response_only.covariances import BandCovariances, TooShortError, segment_covariances
from modallab.identification.response_only.half_spectra import LAGS, HalfSpectra
from modallab.identification.response_only.subspace import OrderPolesWithSlopes, Subspace

ROWS = 320
"""Of the block Hankel matrix, about."""
BLOCK_ROWS = (20, 32)
SIZES = (0.5, 1.0, 2.0)
"""Of block rows, times those: what one size loses by chance, another one holds."""
HIGHEST = 60
"""Order: thirty modes a band."""
ASKED = 12
"""Orders of each size that are looked at, more of the low ones: they spread a mode least."""
WELL_KNOWN = 0.1
"""The look at this quantile of the sigmas stands for a pole: at high orders poles of noise lean on it."""
SPARE = 2
"""An order that holds fewer than the modes there are and so many more is too low to be unbiased."""
MAX_ZETA = 0.2
REACH, LEAST_REACH = 3.0, 2e-3
"""Sigmas, and share of the pole's size, within which poles of two orders are one."""
LIKE = 0.5
"""MAC from which shapes are alike."""
UNKNOWN = 8.0
"""A pole known so many times worse than the best that its decays in the records allow is one of noise."""
LEAST_CONFIDENCE = 0.4
"""Noise alone seldom comes to more than 0.2."""
AT_EDGE = 0.03
"""Share by which a band looks beyond its edges: a mode there is found by both."""


@dataclass(frozen=True, eq=False, slots=True)
class ObservedMode:
    """A pole as one order saw it, and later the mode that it stands for.

    Attributes:
        value: (2,) omega in rad/s and zeta.
        sigma: (2,) of them.
        shape: (outputs,) 1 at the largest.
        shape_sigma: (outputs,) of the complex number.
        order: that saw it.
        confidence: 0 to 1, of the mode.
    """

    value: Real
    sigma: Real
    shape: Complex128
    shape_sigma: Real
    order: int = 0
    confidence: float = 0.0

    @property
    def relative(self) -> float:
        """Sigma of the pole as a share of its size."""
        return float(np.hypot(self.sigma[0] / self.value[0], self.sigma[1]))


class PoleSolver(Protocol):
    """Poles of covariances at any of some orders, with what moves them."""

    @property
    def orders(self) -> tuple[int, ...]:
        """Which, rising; an order is the number of poles."""
        ...

    def at(self, order: int) -> OrderPolesWithSlopes:
        """Those of one order, with what each segment's deviation moves."""
        ...


@dataclass(frozen=True, slots=True)
class PoleMethod:
    """How poles of covariances are found.

    Attributes:
        lags: how many of them, one or more choices, by the number of outputs.
        solve: covariances (segments, lags, outputs, outputs), their rate, and the highest order.
    """

    lags: Callable[[int], tuple[int, ...]]
    solve: Callable[[Real, float, int], PoleSolver]


def _lags_for_outputs(outputs: int) -> tuple[int, ...]:
    rows = int(np.clip(ROWS // outputs, *BLOCK_ROWS))
    return tuple(2 * int(rows * size) for size in SIZES if rows * size * outputs <= SIZES[-1] * ROWS)


SSI_COV = PoleMethod(_lags_for_outputs, Subspace)
PLSCF = PoleMethod(lambda outputs: (LAGS,), HalfSpectra)


def modes_of_band(band: BandCovariances, scale: Real, method: PoleMethod) -> list[ObservedMode]:
    """The modes of one band.

    Args:
        band: records of unit power.
        scale: (outputs,) by which they were divided.
        method: how poles are found.

    Raises:
        DataError: too short records.
    """
    seconds = sum(r.shape[1] for r in band.records) / band.rate_hz
    low, high = 2 * np.pi * band.low_hz * (1 - AT_EDGE), 2 * np.pi * band.high_hz * (1 + AT_EDGE)
    looks = list(_poles_of_all_sizes(band, scale, method, seconds))
    near = [[m for m in look if low <= m.value[0] <= high and 0 < m.value[1] < MAX_ZETA] for look in looks]
    rated = [(group, _confidence_of_group(group, len(looks), seconds)) for group in _group_poles(near)]
    held = [(group, sure) for group, sure in rated if sure > LEAST_CONFIDENCE]
    return [replace(_well_known(group, 2 * (len(held) + SPARE)), confidence=sure) for group, sure in held]


def _poles_of_all_sizes(
    band: BandCovariances, scale: Real, method: PoleMethod, seconds: float
) -> Iterator[list[ObservedMode]]:
    """The poles of every order of every size that the records are long enough for."""
    sizes = method.lags(len(band.records[0]))
    for lags in sizes:
        try:
            covariances = segment_covariances(band, lags)
        except TooShortError:
            if lags == sizes[0]:
                raise
            return
        solver = method.solve(covariances, band.rate_hz, HIGHEST)
        count = len(solver.orders)
        for k in np.unique(np.geomspace(1, count, min(count, ASKED)).astype(int) - 1):
            order = solver.orders[k]
            at = solver.at(order)
            modes = [_seen_mode(at, r, scale, seconds / len(covariances)) for r in range(at.poles.size)]
            yield [replace(mode, order=order) for mode in modes]


def _group_poles(looks: Sequence[Sequence[ObservedMode]]) -> Iterator[list[ObservedMode]]:
    """Poles that are one, at most one of each look; the best known pole gathers first."""
    free = [(n, m) for n, look in enumerate(looks) for m in look]
    free.sort(key=lambda item: item[1].relative)
    while free:
        seed = free[0][1]
        reach = max(REACH * seed.relative, LEAST_REACH)
        apart = {
            k: _pole_distance(m, seed)
            for k, (_, m) in enumerate(free)
            if _pole_distance(m, seed) < reach and shapes_agree(m, seed)
        }
        nearest = {free[k][0]: k for k in sorted(apart, key=lambda k: -apart[k])}
        yield [free[k][1] for k in nearest.values()]
        free = [item for k, item in enumerate(free) if k not in nearest.values()]


def _pole_distance(one: ObservedMode, other: ObservedMode) -> float:
    return float(max(abs(one.value[0] / other.value[0] - 1), abs(one.value[1] - other.value[1])))


def _confidence_of_group(group: Sequence[ObservedMode], looks: int, seconds: float) -> float:
    best = min(group, key=lambda m: m.relative)
    omega, zeta = best.value
    # Of one mode that answers white noise, without any other noise, 1 / (zeta omega T) is the least relative variance.
    worse = best.relative / float(np.sqrt(zeta / (omega * seconds)))
    return len(group) / looks * max(0.0, 1 - (worse / UNKNOWN) ** 2)


def _well_known(group: Sequence[ObservedMode], least_order: int) -> ObservedMode:
    """Of one pole at several orders, the one that stands for it."""
    high = [mode for mode in group if mode.order >= least_order] or list(group)
    ordered = sorted(high, key=lambda m: float(m.sigma[0]))
    return ordered[int(WELL_KNOWN * len(ordered))]


def _seen_mode(at: OrderPolesWithSlopes, r: int, scale: Real, length_s: float) -> ObservedMode:
    pole, moved = at.poles[r], at.moved[:, r]
    omega = abs(pole)
    by_omega = np.real(np.conj(pole) * moved) / omega
    by_zeta = -moved.real / omega + pole.real * by_omega / omega**2
    wider = _sigma_factor(len(moved), -pole.real, length_s)
    count = len(moved) * (len(moved) - 1)
    sigma = np.sqrt(np.array([np.sum((x - x.mean()) ** 2) for x in (by_omega, by_zeta)]) / count)
    shape = at.shapes[r] * scale
    shapes_moved = at.shapes_moved[:, r] * scale
    spread = np.sqrt(np.sum(np.abs(shapes_moved - shapes_moved.mean(axis=0)) ** 2, axis=0) / count)
    largest = shape[np.argmax(np.abs(shape))]
    return ObservedMode(
        np.array([omega, -pole.real / omega]), wider * sigma, shape / largest, wider * spread / np.abs(largest)
    )


def _sigma_factor(segments: int, decay: float, length_s: float) -> float:
    """By how much the segments' scatter understates a sigma.

    The power of a mode stays as it is for 1 / (2 decay), so that neighbouring segments are alike; and of few segments
    the scatter is known roughly, which Student's interval allows for.
    """
    alike = min(0.5, 1 / max(2 * decay * length_s, 1e-9))
    student = stdtrit(segments - 1, 0.975) / ndtri(0.975)
    return float(student / np.sqrt(1 - alike))


def shapes_agree(one: ObservedMode, other: ObservedMode) -> bool:
    """Whether the shapes of two poles may be one."""
    cross = abs(np.vdot(one.shape, other.shape)) ** 2
    return bool(cross >= LIKE * np.vdot(one.shape, one.shape).real * np.vdot(other.shape, other.shape).real)
