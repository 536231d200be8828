"""What each row of the converter sees of the beam."""

from modallab.core.errors import ConfigurationError
from modallab.core.rig import Channel, Rig
from modallab_simulators.cantilever.effects.injected import Injected
from modallab_simulators.cantilever.loads import Output
from modallab_simulators.cantilever.sensor import Sensor, high_pass, low_pass, mount

_ORDER = {"displacement": 0, "velocity": 1, "acceleration": 2}


def outputs_of(rig: Rig, effects: Injected) -> tuple[Output, ...]:
    """One output per row, in rig order.

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
    sensors = sensor_rows(rig, effects)
    return tuple(_output(rig, rig.channels[sensor], row, effects) for row, sensor in enumerate(sensors))


def sensor_rows(rig: Rig, effects: Injected) -> list[int]:
    """Which channel's sensor is wired to each row."""
    rows = list(range(len(rig.channels)))
    for swap in effects.of("swap"):
        pair = swap.place["channel"]
        assert isinstance(pair, tuple)
        rows[pair[0]], rows[pair[1]] = rows[pair[1]], rows[pair[0]]
    return rows


def _output(rig: Rig, channel: Channel, row: int, effects: Injected) -> Output:
    if channel.mass_kg:
        raise ConfigurationError(
            f"mass_kg is {channel.mass_kg}",
            where=f"channel {channel.name}",
            remedy="the simulated sensors have none: 0; the effect sensor_mass gives them one",
        )
    later = row * effects.number("channel_skew", "seconds_per_channel", 0.0)
    if channel.quantity == "force":
        return Output("force", later_s=later)
    if channel.quantity == "voltage":
        return Output("voltage", later_s=later)
    if channel.point is None:
        raise ConfigurationError(
            f"a {channel.quantity} that stands at no point", where=f"channel {channel.name}", remedy="give it a point"
        )
    later += effects.number("trigger_delay", "seconds", 0.0)
    moved = effects.on("position_error", channel.index)
    x_m = rig.x_of(channel.point) + (moved.parameters["dx"] if moved else 0.0)
    return Output("motion", x_m, _ORDER[channel.quantity], later, _sensor(channel, effects))


def _sensor(channel: Channel, effects: Injected) -> Sensor:
    sensor = Sensor()
    if channel.quantity != "acceleration":
        return sensor
    corner = effects.one("ac_coupling")
    if corner:
        sensor = sensor.then(high_pass(corner.parameters["corner_hz"]))
    loose = effects.on("loose_mount", channel.index)
    if loose:
        sensor = sensor.then(mount(loose.parameters["hz"], loose.parameters["zeta"]))
    lag = effects.on("preamp_lag", channel.index)
    if lag:
        sensor = sensor.then(low_pass(lag.parameters["corner_hz"]))
    return sensor
