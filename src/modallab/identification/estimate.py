"""The first poles of an identification, by whichever estimator is asked for."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.array_checks import check_frf
from modallab.core.arrays import Complex128
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.identification.estimator import ModelOrder, find_estimator
from modallab.identification.start.bands import SearchBand, split_bands
from modallab.identification.start.half_power import half_power_pole, poles_of_peaks
from modallab.identification.start.stabilisation import OrderPoles, StabilityLimits, stable_poles

CROWDED = 0.4
"""Where stable poles take up this share of what the highest order can hold, the range is cut into bands."""


FEW_ORDERS = 30
"""Up to so many orders, a pole need not have held over five of them to be looked at."""
DAMPED = StabilityLimits(max_zeta=0.2)
BRIEFLY = StabilityLimits(frequency=5e-3, damping=2e-2, min_run=2, min_share=0.1)


@dataclass(frozen=True, eq=False, slots=True)
class PoleEstimate:
    """What an estimator found.

    Attributes:
        poles: (poles,) rad/s with positive imaginary part, those that are taken for modes.
        orders: all poles by rising order; none for estimators that have no order.
    """

    poles: Complex128
    orders: tuple[OrderPoles, ...] = ()


def estimate_poles(
    frf: Frf, method: str, max_order: int | None = None, tolerance: StabilityLimits | None = None
) -> PoleEstimate:
    """Poles of FRFs by one of the estimators.

    Args:
        frf: any quantity; a damping shift is taken off the poles again.
        method: name of an estimator. One with orders gives the poles that are stable over rising ones.
        max_order: highest order; None for one that the lines can carry, and for bands of their own where the range
            holds many modes.
        tolerance: when poles of two orders are the same.

    Raises:
        DataError: the FRF is not finite, has no phase, or its lines do not suit the estimator.
        IdentificationError: no such estimator, or the lines cannot carry the order.
    """
    used = find_estimator(method)
    if max_order is not None and max_order < 1:
        raise IdentificationError(f"order {max_order} holds no mode", remedy="ask for an order of at least 2")
    check_frf(frf.frequency_hz, frf.values, frf.outputs, even=used.grid == "even")
    frf = with_fewer_inputs(frf)
    if used.poles is not None:
        return PoleEstimate(used.poles(frf))
    assert used.order is not None
    return _poles_of_orders(frf, used.order, max_order, tolerance)


def poles_without_stability(frf: Frf, estimate: PoleEstimate) -> Complex128:
    """Poles that may be looked at where none is stable, as such stand.

    That are poles damped by more than usual; and in lines too few for orders to rise, as those of a mode alone in a
    narrow band, clear peaks. Whether these are modes, the search for the maximum of the likelihood must say.

    Args:
        frf: what was estimated from.
        estimate: without poles.
    """
    held = _stable_poles(estimate.orders, DAMPED)
    if held.size or len(estimate.orders) > FEW_ORDERS:
        return held
    held = _stable_poles(estimate.orders, BRIEFLY)
    return held if held.size else poles_of_peaks(frf, half_power_pole)


def with_fewer_inputs(frf: Frf) -> Frf:
    """The FRFs with outputs and inputs exchanged where there are more inputs than outputs: the poles are the same.

    An order shared among many inputs is too low for the modes there are.
    """
    n_out, n_in, _ = frf.values.shape
    if n_in <= n_out:
        return frf
    return replace(
        frf,
        values=np.ascontiguousarray(frf.values.transpose(1, 0, 2)),
        outputs=tuple(f"input {k + 1}" for k in range(n_in)),
        output_points=frf.input_points,
        input_points=frf.output_points,
        averages=(),
        coherence=None,
        variance=None,
    )


def _poles_of_orders(
    frf: Frf, order: ModelOrder, max_order: int | None, tolerance: StabilityLimits | None
) -> PoleEstimate:
    orders = order.solve(frf, max_order or order.suits(frf))
    whole = PoleEstimate(_stable_poles(orders, tolerance), tuple(orders))
    if max_order is not None or whole.poles.size < CROWDED * orders[-1].order * order.modes(frf):
        return whole
    bands = split_bands(frf)
    return (
        whole
        if len(bands) == 1
        else _join_estimates([_estimate_in_band(frf, band, order, tolerance) for band in bands])
    )


def _estimate_in_band(frf: Frf, band: SearchBand, order: ModelOrder, tolerance: StabilityLimits | None) -> PoleEstimate:
    inside = band.cut(frf)
    orders = order.solve(inside, order.suits(inside))
    own = tuple(OrderPoles(o.order, band.own(o.poles)) for o in orders)
    return PoleEstimate(band.own(_stable_poles(orders, tolerance)), own)


def _join_estimates(parts: Sequence[PoleEstimate]) -> PoleEstimate:
    every = sorted({o.order for part in parts for o in part.orders})
    orders = [
        OrderPoles(n, np.concatenate([o.poles for part in parts for o in part.orders if o.order == n])) for n in every
    ]
    return PoleEstimate(np.concatenate([part.poles for part in parts]), tuple(orders))


def _stable_poles(orders: Sequence[OrderPoles], tolerance: StabilityLimits | None) -> Complex128:
    return np.array([p.pole for p in stable_poles(orders, tolerance)], dtype=np.complex128)
