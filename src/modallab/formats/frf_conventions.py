"""How tables and arrays of others hold FRFs: units and directions of the rig's channels, order of lines, percent."""

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, FrfQuantity
from modallab.core.rig import Channel, Rig
from modallab.core.units import DERIVATIVE, si_factor
from modallab.signals.conversion import sign_of

_QUANTITY: dict[int, FrfQuantity] = {order: quantity for quantity, order in DERIVATIVES.items()}
_ROUNDING = 1e-6


def assumed_factor(channel: Channel, rig: Rig, where: str) -> tuple[FrfQuantity, float]:
    """Quantity of the FRFs of a channel, and the factor from the units of the rig's channels to SI.

    Raises:
        DataError: the channel measures no motion.
    """
    order = DERIVATIVE.get(channel.quantity)
    if order is None:
        raise DataError(
            f"channel {channel.name} measures {channel.quantity}, of which no modal FRF is made",
            where=where,
            remedy="leave it out of the rig, or mend its quantity",
        )
    force = 1.0 if rig.force is None else si_factor("force", rig.force.unit, where)
    return _QUANTITY[order], si_factor(channel.quantity, channel.unit, where) / force


def turned(channel: Channel, rig: Rig) -> float:
    """1 or -1: what turns the FRF of a channel to the direction of the drive, as its records are turned."""
    return sign_of(rig, channel) * (1.0 if rig.force is None else sign_of(rig, rig.force))


def rising(frequency_hz: Real, values: Complex128, coherence: Real | None) -> tuple[Real, Complex128, Real | None]:
    """Lines (lines,), FRFs and coherences (outputs, inputs, lines) by rising frequency, of a sweep down too."""
    if frequency_hz.size < 2 or not np.all(np.diff(frequency_hz) < 0):
        return frequency_hz, values, coherence
    turned = None if coherence is None else coherence[..., ::-1]
    return frequency_hz[::-1], values[..., ::-1], turned


def share_of_one(coherence: Real, where: str, unit: str = "") -> Real:
    """Coherences, those in % as shares.

    Raises:
        DataError: they are not between 0 and 1.
    """
    share = coherence / 100 if unit == "%" else coherence
    if not ((share >= 0) & (share <= 1 + _ROUNDING)).all():
        raise DataError(
            f"a coherence is not between 0 and 1: they reach {float(np.max(share)):.4g}",
            where=where,
            remedy="write [%] behind the names of columns in percent, or export the coherences again",
        )
    return np.minimum(share, 1.0)
