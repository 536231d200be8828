"""What FRFs of a table or array are in: the units and directions of the rig's channel over those of its force."""

from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, FrfQuantity
from modallab.core.rig import Channel, Rig
from modallab.core.units import DERIVATIVE, si_factor
from modallab.signals.conversion import sign_of

_QUANTITY: dict[int, FrfQuantity] = {order: quantity for quantity, order in DERIVATIVES.items()}


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
