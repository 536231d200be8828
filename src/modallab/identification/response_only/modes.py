"""Modes of responses alone: which poles are modes, and how well each is known."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit

from modallab.core.errors import DataError, IdentificationError
from modallab.core.progress import report
from modallab.identification.response_only.covariances import Band, bands, segment_covariances
from modallab.identification.response_only.half_spectra import LAGS, HalfSpectra
from modallab.identification.response_only.subspace import Poles, Subspace
from modallab.identification.start.stabilisation import OrderPoles, StablePole, Tolerance, stable_poles

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROWS = 320
"""Of the block Hankel matrix, about."""
BLOCK_ROWS = (20, 32)
HIGHEST = 60
"""Order: thirty modes a band."""
SAME = Tolerance(frequency=4e-3, damping=1e-2, max_zeta=0.2)
ASKED = 8
"""Orders among those that hold a pole whose sigmas are looked at."""
WELL_KNOWN = 0.25
"""The order at this quantile of the sigmas stands for a pole: at high orders poles of noise lean on it."""
SPARE = 2
"""An order that holds fewer than the modes there are and so many more is too low to be unbiased."""
MAX_SIGMA = (0.01, 0.5)
"""Relative, of frequency and damping ratio: beyond, a pole fits noise."""
SURE, BEST = 0.2, 4.0
"""A damping ratio must be known to this share, or to so many times the best that its decays in the records allow: a
pole of noise is known much worse than a mode that rings as long."""
TWICE = 0.01
"""Relative distance of poles of two bands that are one."""
AT_EDGE = 0.03
"""Share by which a band looks beyond its edges: a mode there is found by both."""


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
    """

    frequency_hz: Real
    damping_ratio: Real
    frequency_sigma_hz: Real
    damping_sigma: Real
    shapes: Complex
    shape_sigma: Real


@dataclass(frozen=True, eq=False, slots=True)
class _Mode:
    value: Real
    sigma: Real
    shape: Complex
    shape_sigma: Real


class Solver(Protocol):
    """Poles of covariances at rising orders, and at one of them with what moves them."""

    def orders(self) -> list[OrderPoles]:
        """Poles at rising orders; an order is the number of poles."""
        ...

    def at(self, order: int) -> Poles:
        """Those of one order, with what each segment's deviation moves."""
        ...


@dataclass(frozen=True, slots=True)
class Method:
    """How poles of covariances are found.

    Attributes:
        lags: how many of them, by the number of outputs.
        solve: covariances (segments, lags, outputs, outputs), their rate, and the highest order.
    """

    lags: Callable[[int], int]
    solve: Callable[[Real, float, int], Solver]


SSI_COV = Method(lambda outputs: 2 * int(np.clip(ROWS // outputs, *BLOCK_ROWS)), Subspace)
PLSCF = Method(lambda outputs: LAGS, HalfSpectra)


def response_modes(
    records: Sequence[Real], rate_hz: float, band_hz: tuple[float, float], method: Method = SSI_COV
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
    _check(records, rate_hz, band_hz)
    still = [r - r.mean(axis=1, keepdims=True) for r in records]
    scale = np.sqrt(np.mean(np.concatenate(still, axis=1) ** 2, axis=1))
    found: list[_Mode] = []
    parts = list(bands([r / scale[:, None] for r in still], rate_hz, band_hz))
    for k, band in enumerate(parts):
        report(k / len(parts), f"{band.low_hz:.3g} to {band.high_hz:.3g} Hz")
        found += _of_band(band, scale, method)
    modes = _each_once(found)
    if not modes:
        raise IdentificationError(
            f"no pole between {band_hz[0]:.4g} and {band_hz[1]:.4g} Hz is stable and known",
            remedy="record longer, widen the band, or look whether the responses move at all",
        )
    value, sigma = np.array([m.value for m in modes]), np.array([m.sigma for m in modes])
    return ResponseModes(
        frequency_hz=value[:, 0] / (2 * np.pi),
        damping_ratio=value[:, 1],
        frequency_sigma_hz=sigma[:, 0] / (2 * np.pi),
        damping_sigma=sigma[:, 1],
        shapes=np.array([m.shape for m in modes]),
        shape_sigma=np.array([m.shape_sigma for m in modes]),
    )


def _check(records: Sequence[Real], rate_hz: float, band_hz: tuple[float, float]) -> None:
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


def _of_band(band: Band, scale: Real, method: Method) -> list[_Mode]:
    covariances = segment_covariances(band, method.lags(len(band.records[0])))
    length_s = sum(r.shape[1] for r in band.records) / band.rate_hz / len(covariances)
    solver = method.solve(covariances, band.rate_hz, HIGHEST)
    orders = solver.orders()
    low, high = 2 * np.pi * band.low_hz * (1 - AT_EDGE), 2 * np.pi * band.high_hz * (1 + AT_EDGE)
    known: dict[int, Poles] = {}
    seconds = length_s * len(covariances)
    each: list[list[tuple[int, _Mode]]] = []
    for stable in stable_poles(orders, SAME):
        if not low <= abs(stable.pole) <= high:
            continue
        holding = [o.order for o in orders if np.any(_near(o.poles, stable))]
        asked: list[tuple[int, _Mode]] = []
        for place in np.unique(np.linspace(0, len(holding) - 1, min(len(holding), ASKED)).astype(int)):
            order = holding[place]
            if order not in known:
                known[order] = solver.at(order)
            at = known[order]
            asked.append((order, _mode(at, int(np.argmin(np.abs(at.poles - stable.pole))), scale, length_s)))
        held = [(order, mode) for order, mode in asked if _known(mode, seconds)]
        if held:
            each.append(held)
    return [_well_known(held, 2 * (len(each) + SPARE)) for held in each]


def _well_known(held: Sequence[tuple[int, _Mode]], least_order: int) -> _Mode:
    """Of one pole at several orders, the one that stands for it."""
    high = [mode for order, mode in held if order >= least_order] or [mode for _, mode in held]
    ordered = sorted(high, key=lambda m: float(m.sigma[0]))
    return ordered[int(WELL_KNOWN * len(ordered))]


def _near(poles: Complex, stable: StablePole) -> NDArray[np.bool_]:
    away, size = poles - stable.pole, abs(stable.pole)
    return (np.abs(away.imag) < SAME.frequency * size) & (np.abs(away.real) < SAME.damping * size)


def _known(mode: _Mode, seconds: float) -> bool:
    omega, zeta = mode.value
    if not 0 < zeta < SAME.max_zeta or np.any(mode.sigma > np.array(MAX_SIGMA) * mode.value):
        return False
    # Of one mode that answers white noise, without any other noise, 1 / (zeta omega T) is the least variance.
    return bool(mode.sigma[1] / zeta < max(SURE, BEST / np.sqrt(zeta * omega * seconds)))


def _mode(at: Poles, r: int, scale: Real, length_s: float) -> _Mode:
    pole, moved = at.poles[r], at.moved[:, r]
    omega = abs(pole)
    by_omega = np.real(np.conj(pole) * moved) / omega
    by_zeta = -moved.real / omega + pole.real * by_omega / omega**2
    wider = _wider(len(moved), -pole.real, length_s)
    count = len(moved) * (len(moved) - 1)
    sigma = np.sqrt(np.array([np.sum((x - x.mean()) ** 2) for x in (by_omega, by_zeta)]) / count)
    shape = at.shapes[r] * scale
    shapes_moved = at.shapes_moved[:, r] * scale
    spread = np.sqrt(np.sum(np.abs(shapes_moved - shapes_moved.mean(axis=0)) ** 2, axis=0) / count)
    largest = shape[np.argmax(np.abs(shape))]
    return _Mode(
        np.array([omega, -pole.real / omega]), wider * sigma, shape / largest, wider * spread / np.abs(largest)
    )


def _wider(segments: int, decay: float, length_s: float) -> float:
    """By how much the segments' scatter understates a sigma.

    The power of a mode stays as it is for 1 / (2 decay), so that neighbouring segments are alike; and of few segments
    the scatter is known roughly, which Student's interval allows for.
    """
    alike = min(0.5, 1 / max(2 * decay * length_s, 1e-9))
    student = stdtrit(segments - 1, 0.975) / ndtri(0.975)
    return float(student / np.sqrt(1 - alike))


def _each_once(modes: Sequence[_Mode]) -> list[_Mode]:
    """Of poles that two bands found for one mode, the better known."""
    taken: list[_Mode] = []
    for mode in sorted(modes, key=lambda m: float(m.sigma[0] / m.value[0])):
        if all(abs(mode.value[0] / other.value[0] - 1) > TWICE or _unlike(mode, other) for other in taken):
            taken.append(mode)
    return sorted(taken, key=lambda m: float(m.value[0]))


def _unlike(one: _Mode, other: _Mode) -> bool:
    cross = abs(np.vdot(one.shape, other.shape)) ** 2
    return bool(cross < 0.5 * np.vdot(one.shape, one.shape).real * np.vdot(other.shape, other.shape).real)
