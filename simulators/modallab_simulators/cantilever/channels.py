"""What each channel of the rig sees of the beam."""

from modallab.errors import ConfigurationError
from modallab.schema.rig import Channel, Rig
from modallab_simulators.cantilever.structure import Output

_ORDER = {"displacement": 0, "velocity": 1, "acceleration": 2}


def outputs_of(rig: Rig) -> tuple[Output, ...]:
    """One output per channel, in rig order.

    Raises:
        ConfigurationError: a response without a point, a force transducer across the drive, a sensor with mass.
    """
    force = rig.force_channel
    if force.direction[1] != rig.drive_direction[1]:
        raise ConfigurationError(
            f"measures along {force.direction}, the drive is along {rig.drive_direction}",
            where=f"channel {force.name}",
            remedy="turn the force transducer into the drive's direction",
        )
    return tuple(_output(rig, channel) for channel in rig.channels)


def _output(rig: Rig, channel: Channel) -> Output:
    if channel.mass_kg:
        raise ConfigurationError(
            f"mass_kg is {channel.mass_kg}",
            where=f"channel {channel.name}",
            remedy="the simulated sensors have none: 0",
        )
    if channel.quantity == "force":
        return Output("force")
    if channel.quantity == "voltage":
        return Output("voltage")
    if channel.point is None:
        raise ConfigurationError(
            f"a {channel.quantity} that stands at no point", where=f"channel {channel.name}", remedy="give it a point"
        )
    return Output("motion", rig.x_of(channel.point), _ORDER[channel.quantity])
