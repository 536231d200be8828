"""What each row of the converter sees of the beam."""

from modallab.core.errors import ConfigurationError
from modallab.core.rig import Channel, Rig
from modallab_simulators.cantilever.altered import ChainChanges
from modallab_simulators.cantilever.loads import Output
from modallab_simulators.cantilever.sensor import Sensor

_ORDER = {"displacement": 0, "velocity": 1, "acceleration": 2}


def outputs_of(rig: Rig, changes: ChainChanges) -> tuple[Output, ...]:
    """One output per row, in rig order.

    Raises:
        ConfigurationError: a response without a point, a force transducer across the drive, a sensor with mass.
    """
    for force in (rig.force_channel, *rig.forces[1:]):
        if force.direction[1] != rig.drive_direction[1]:
            raise ConfigurationError(
                f"measures along {force.direction}, the drive is along {rig.drive_direction}",
                where=f"channel {force.name}",
                remedy="turn the force transducer into the drive's direction",
            )
    sensors = sensor_rows(rig, changes)
    return tuple(_output(rig, rig.channels[sensor], row, changes) for row, sensor in enumerate(sensors))


def sensor_rows(rig: Rig, changes: ChainChanges) -> list[int]:
    """Which channel's sensor is wired to each row."""
    rows = list(range(len(rig.channels)))
    for one, other in changes.exchanged:
        rows[one], rows[other] = rows[other], rows[one]
    return rows


def _output(rig: Rig, channel: Channel, row: int, changes: ChainChanges) -> Output:
    if channel.mass_kg:
        raise ConfigurationError(
            f"mass_kg is {channel.mass_kg}",
            where=f"channel {channel.name}",
            remedy="the simulated sensors have none: 0; the effect sensor_mass gives them one",
        )
    later = row * changes.skew_s
    if channel.quantity == "force":
        shaker = next(n for n, force in enumerate(rig.forces) if force.name == channel.name)
        return Output("force", later_s=later, shaker=shaker)
    if channel.quantity == "voltage":
        return Output("voltage", later_s=later)
    if channel.point is None:
        raise ConfigurationError(
            f"a {channel.quantity} that stands at no point", where=f"channel {channel.name}", remedy="give it a point"
        )
    later += changes.delay_s
    x_m = rig.x_of(channel.point) + changes.moved_m.get(channel.index, 0.0)
    return Output("motion", x_m, _ORDER[channel.quantity], later, _sensor(channel, changes))


def _sensor(channel: Channel, changes: ChainChanges) -> Sensor:
    sensor = Sensor()
    if channel.quantity != "acceleration":
        return sensor
    for row, own in changes.filters:
        if row is None or row == channel.index:
            sensor = sensor.then(own)
    return sensor
