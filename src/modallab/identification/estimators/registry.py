"""The estimators that give an identification its first poles: parameters in, poles out, whichever is asked for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_frf
from modallab.core.errors import DataError, IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import Method
from modallab.frf.estimate import convert
from modallab.identification.estimators.bands import Band, split_bands
from modallab.identification.estimators.circle_fit import circle_fit
from modallab.identification.estimators.era import era
from modallab.identification.estimators.half_power import Peak, find_peaks, summed_amplitude
from modallab.identification.estimators.plscf import OrderPoles, plscf
from modallab.identification.estimators.stabilisation import Tolerance, stable_poles

Complex = NDArray[np.complex128]

COLUMNS = 120
"""Default order of pLSCF: this many polynomial columns, shared among the inputs; of ERA: this many states."""
LEAST_ZETA = 1e-5
"""A pole read off a peak is given at least this damping: the artificial one is taken off a rough reading."""
CROWDED = 0.4
"""Where stable poles take up this share of what the highest order can hold, the range is cut into bands."""
CIRCLE_FALL = 0.4
"""A circle is fitted to the lines about a peak down to this share of its amplitude: well past half-power."""
CIRCLE_LINES = 5


@dataclass(frozen=True, eq=False, slots=True)
class PoleEstimate:
    """What an estimator found.

    Attributes:
        poles: (poles,) rad/s with positive imaginary part, those that are taken for modes.
        orders: all poles by rising order; none for estimators that have no order.
    """

    poles: Complex
    orders: tuple[OrderPoles, ...] = ()


def estimate_poles(
    frf: Frf, method: Method, max_order: int | None = None, tolerance: Tolerance | None = None
) -> PoleEstimate:
    """Poles of FRFs by one of the estimators.

    Args:
        frf: any quantity; a damping shift is taken off the poles again.
        method: "plscf" and "era" give the poles that are stable over rising orders; "peak" reads each peak by the
            half-power rule, "circle" fits a circle to the lines about it.
        max_order: highest order of pLSCF, or number of states of ERA; None for one that the lines can carry, and for
            bands of their own where the range holds many modes.
        tolerance: when poles of two orders are the same.

    Raises:
        DataError: the FRF is not finite, has no phase, or its lines do not suit the estimator.
        IdentificationError: the lines cannot carry the order.
    """
    if max_order is not None and max_order < 1:
        raise IdentificationError(f"order {max_order} holds no mode", remedy="ask for an order of at least 2")
    if method in ("peak", "circle"):
        return PoleEstimate(_of_peaks(frf, _half_power_pole if method == "peak" else _circle_pole))
    orders = rising_orders(frf, method, max_order)
    whole = PoleEstimate(_stable(orders, tolerance), tuple(orders))
    if max_order is not None or whole.poles.size < CROWDED * orders[-1].order * _per_order(frf, method):
        return whole
    bands = split_bands(frf)
    return whole if len(bands) == 1 else _joined([_in_band(frf, band, method, tolerance) for band in bands])


def _per_order(frf: Frf, method: Method) -> float:
    """Modes that one more order can hold."""
    return 0.5 if method == "era" else frf.values.shape[1] / 2


def _in_band(frf: Frf, band: Band, method: Method, tolerance: Tolerance | None) -> PoleEstimate:
    orders = rising_orders(band.cut(frf), method)
    own = tuple(OrderPoles(o.order, band.own(o.poles)) for o in orders)
    return PoleEstimate(band.own(_stable(orders, tolerance)), own)


def _joined(parts: Sequence[PoleEstimate]) -> PoleEstimate:
    every = sorted({o.order for part in parts for o in part.orders})
    orders = [
        OrderPoles(n, np.concatenate([o.poles for part in parts for o in part.orders if o.order == n])) for n in every
    ]
    return PoleEstimate(np.concatenate([part.poles for part in parts]), tuple(orders))


def rising_orders(frf: Frf, method: Method, max_order: int | None = None) -> list[OrderPoles]:
    """Poles by rising order: of ERA if that is the method, else of pLSCF. Arguments as for `estimate_poles`."""
    check_frf(frf.frequency_hz, frf.values, frf.outputs, even=False)
    n_lines = frf.frequency_hz.size
    if method == "era":
        return era(frf, max_order or max(2, min(COLUMNS, n_lines // 4)))
    return plscf(frf, max_order or max(2, min(COLUMNS // frf.values.shape[1], n_lines // 2 - 1)))


def _stable(orders: Sequence[OrderPoles], tolerance: Tolerance | None) -> Complex:
    return np.array([p.pole for p in stable_poles(orders, tolerance)], dtype=np.complex128)


def _of_peaks(frf: Frf, read: Callable[[Frf, Peak], complex]) -> Complex:
    mobility = convert(frf, "mobility")
    poles: list[complex] = []
    for peak in find_peaks(mobility.frequency_hz, summed_amplitude(mobility)):
        pole = read(mobility, peak) + frf.damping_shift
        poles.append(complex(min(pole.real, -LEAST_ZETA * abs(pole.imag)), pole.imag))
    return np.array(poles, dtype=np.complex128)


def _pole(frequency_hz: float, zeta: float) -> complex:
    omega = 2 * np.pi * frequency_hz
    return complex(-zeta * omega, omega * np.sqrt(max(1 - zeta**2, 0.0)))


def _half_power_pole(mobility: Frf, peak: Peak) -> complex:
    """Where a flank is missing the width is that of one line."""
    f = mobility.frequency_hz
    spacing = float(f[min(peak.line + 1, f.size - 1)] - f[max(peak.line - 1, 0)]) / 2
    known = np.isfinite(peak.damping_ratio)
    return _pole(peak.frequency_hz, peak.damping_ratio if known else spacing / (2 * peak.frequency_hz))


def _circle_pole(mobility: Frf, peak: Peak) -> complex:
    """From the FRF that is loudest at the peak; where its lines stand on no circle, what half-power reads."""
    size = np.abs(mobility.values[..., peak.line])
    o, i = np.unravel_index(int(np.argmax(size)), size.shape)
    values = mobility.values[o, i]
    lines = _about(np.abs(values), peak.line)
    try:
        found = circle_fit(mobility.frequency_hz[lines], values[lines])
    except (DataError, IdentificationError):
        return _half_power_pole(mobility, peak)
    f = mobility.frequency_hz
    beside = f[max(peak.line - 1, 0)] <= found.frequency_hz <= f[min(peak.line + 1, f.size - 1)]
    # Lines far apart make a circle of noise and neighbours, whose resonance lies anywhere but at the peak.
    sound = beside and found.damping_ratio > 0
    return _pole(found.frequency_hz, found.damping_ratio) if sound else _half_power_pole(mobility, peak)


def _about(amplitude: NDArray[np.float64], line: int) -> slice:
    """The lines about a peak: down to a share of it, five at least."""
    low = high = line
    limit = CIRCLE_FALL * amplitude[line]
    while low > 0 and (amplitude[low - 1] > limit or line - low < CIRCLE_LINES // 2):
        if amplitude[low - 1] > amplitude[low] and line - low >= CIRCLE_LINES // 2:
            break
        low -= 1
    while high < amplitude.size - 1 and (amplitude[high + 1] > limit or high - line < CIRCLE_LINES // 2):
        if amplitude[high + 1] > amplitude[high] and high - line >= CIRCLE_LINES // 2:
            break
        high += 1
    return slice(low, high + 1)
