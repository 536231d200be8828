"""The stabilisation diagram beside the mode indicators: which poles hold as the order rises, and where modes show."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.frf.estimate import convert_frf
from modallab.identification.estimator import USUAL
from modallab.identification.start.bands import cmif, mmif
from modallab.identification.start.stabilisation import OrderPoles, StabilityLimits, stable_poles

NEW, IN_FREQUENCY, STABLE = 0, 1, 2
"""A pole that the order below did not have; had at this frequency with another damping; had."""


@dataclass(frozen=True, eq=False, slots=True)
class StabilisationData:
    """What an identification began with, to be looked at.

    Attributes:
        order: (poles,) order of the polynomial, or number of states, at which a pole was found.
        frequency_hz: (poles,)
        damping_ratio: (poles,)
        standing: (poles,) NEW, IN_FREQUENCY or STABLE.
        held_hz: (held,) frequencies of the poles that hold over enough orders.
        line_hz: (lines,) of the FRFs.
        cmif: (min(outputs, inputs), lines) of the mobility, largest first, (m/(N s))^2.
        mmif: (inputs, lines) 0 to 1, lowest first.
    """

    order: NDArray[np.int64]
    frequency_hz: Real
    damping_ratio: Real
    standing: NDArray[np.int64]
    held_hz: Real
    line_hz: Real
    cmif: Real
    mmif: Real


def stabilisation_diagram(
    frf: Frf, orders: Sequence[OrderPoles], tolerance: StabilityLimits | None = None
) -> StabilisationData:
    """The diagram of FRFs and their poles by rising order.

    Args:
        frf: the FRFs the poles were found in.
        orders: poles by rising order; those that no structure has (growing, or damped too much) are left out.
        tolerance: when poles of two orders are the same.

    Raises:
        DataError: the FRF is not finite, or has no phase.
        IdentificationError: no orders.
    """
    if not orders:
        raise IdentificationError(
            "there are no orders to draw", remedy=f"use an estimator with orders, such as {USUAL}"
        )
    limits = tolerance or StabilityLimits()
    # The artificial damping of the FRFs is off the poles already.
    sound = [limits.plausible(o.poles) for o in orders]
    standing = [_is_stable(here, below, limits) for here, below in zip(sound, [sound[0][:0], *sound[:-1]], strict=True)]
    poles = np.concatenate(sound)
    return StabilisationData(
        order=np.repeat([o.order for o in orders], [s.size for s in sound]),
        frequency_hz=np.abs(poles) / (2 * np.pi),
        damping_ratio=-poles.real / np.abs(poles),
        standing=np.concatenate(standing),
        held_hz=np.array([abs(p.pole) for p in stable_poles(orders, limits)]) / (2 * np.pi),
        line_hz=frf.frequency_hz,
        cmif=cmif(convert_frf(frf, "mobility")),
        mmif=mmif(frf),
    )


def _is_stable(
    here: NDArray[np.complex128], below: NDArray[np.complex128], limits: StabilityLimits
) -> NDArray[np.int64]:
    if not below.size:
        return np.full(here.size, NEW)
    size = np.abs(below)
    same_f = np.abs(here.imag[:, None] - below.imag) < limits.frequency * size
    same = same_f & (np.abs(here.real[:, None] - below.real) < limits.damping * size)
    return np.where(same.any(axis=1), STABLE, np.where(same_f.any(axis=1), IN_FREQUENCY, NEW))
