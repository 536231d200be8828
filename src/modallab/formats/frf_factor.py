"""What FRFs are in where their file names no unit: the rig's channel over the rig's force."""

from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, FrfQuantity
from modallab.core.rig import Channel, Rig
from modallab.core.units import DERIVATIVE, si_factor

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
