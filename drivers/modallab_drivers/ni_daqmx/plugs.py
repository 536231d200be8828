"""Which channel of the rig is plugged into which input of the devices, and whether the input can do it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from modallab.core.errors import ConfigurationError
from modallab.core.rig import Channel, Rig
from modallab_drivers.ni_daqmx.route import DeviceInfo

USUAL_SUPPLY_A = 0.002
SUPPLY_PART = 1e-3
"""A stated current is one of the device's if it differs by no more."""


@dataclass(frozen=True, slots=True)
class Plug:
    """A channel of the rig at its input.

    Attributes:
        channel: of the rig.
        physical: of the device.
        range_v: to set.
        unit: device or chassis whose clock it has.
        supply_a: current that feeds an IEPE sensor; 0 where none is fed.
    """

    channel: Channel
    physical: str
    range_v: float
    unit: str = ""
    supply_a: float = 0.0


def plugs_of(rig: Rig, devices: Sequence[DeviceInfo], where: str) -> tuple[Plug, ...]:
    """The plugs of a rig: inputs as it names them, the others in order.

    Raises:
        ConfigurationError: one message with every field of the rig file that does not fit.
    """
    owners = {name: device for device in devices for name in device.inputs}
    ranges = {name: device.input_range_v for name, device in owners.items()}
    named = {channel.input for channel in rig.channels if channel.input}
    free = [name for name in ranges if name not in named]
    problems: list[str] = []
    plugs: list[Plug] = []
    for place, channel in enumerate(rig.channels):
        physical = channel.input or (free.pop(0) if free else "")
        if not physical:
            problems.append(f"channels[{place}] ({channel.name}): no input is left, there are {len(ranges)}")
            continue
        if physical not in ranges:
            problems.append(f"channels[{place}].input: found {physical!r}; allowed: {_listed(list(ranges))}")
            continue
        plugs.append(_plug(rig, channel, physical, owners[physical], problems))
    if problems:
        raise ConfigurationError("; ".join(problems), where=where, remedy="correct these fields of the rig file")
    return tuple(plugs)


def _plug(rig: Rig, channel: Channel, physical: str, device: DeviceInfo, problems: list[str]) -> Plug:
    most_v = device.input_range_v
    own = f"channels[{channel.index}].range_v" if channel.range_v else "converter.range_v"
    range_v = channel.range_v or (rig.converter.range_v if rig.converter else most_v)
    if range_v > most_v * (1 + 1e-9):
        problems.append(f"{own}: found {range_v:g} V for {physical}; allowed: up to {most_v:g} V")
    return Plug(channel, physical, range_v, device.unit, _supply(channel, device, problems))


def _supply(channel: Channel, device: DeviceInfo, problems: list[str]) -> float:
    if channel.coupling != "IEPE":
        return 0.0
    stated, listed = channel.excitation_a, device.supplies_a
    if not listed:
        # What the device does not list it may still have; it says so itself when the channel is made.
        return stated or USUAL_SUPPLY_A
    if stated is None:
        return min(listed)
    nearest = min(listed, key=lambda current: abs(current - stated))
    if abs(nearest - stated) > SUPPLY_PART * stated:
        allowed = f"{device.product} {device.name} has {', '.join(f'{current:g}' for current in listed)} A"
        problems.append(f"channels[{channel.index}].excitation_a: found {stated:g} A; {allowed}")
    return nearest


def outputs_of(rig: Rig, devices: Sequence[DeviceInfo], where: str) -> tuple[tuple[str, float], ...]:
    """The analog output of each shaker of a rig, and its range: as the rig names them, the others in order.

    There is none if the rig drives otherwise or not at all.

    Raises:
        ConfigurationError: no such output, or none left, or limits beyond its range.
    """
    excitation = rig.excitation
    if rig.shaker_point is None or (excitation is not None and excitation.kind != "analog-output"):
        return ()
    ranges = {name: device.output_range_v for device in devices for name in device.outputs}
    if not ranges and not rig.shakers:
        return ()
    wired = excitation.output if excitation is not None else ""
    fields = {"excitation.output": wired} | {f"shakers[{n}].output": s.output for n, s in enumerate(rig.shakers)}
    free = [name for name in ranges if name not in fields.values()]
    return tuple(
        _output(rig, field, name or (free.pop(0) if free else ""), ranges, where) for field, name in fields.items()
    )


def _output(rig: Rig, field: str, name: str, ranges: Mapping[str, float], where: str) -> tuple[str, float]:
    problem = ""
    if not name:
        problem = f"{field}: no output is left, there are {len(ranges)}"
    elif name not in ranges:
        problem = f"{field}: found {name!r}; allowed: {_listed(list(ranges))}"
    elif rig.limits is not None and rig.limits.drive_v > ranges[name]:
        problem = (
            f"limits.drive_v: found {rig.limits.drive_v:g} V; allowed: up to the range of {name}, {ranges[name]:g} V"
        )
    if problem:
        raise ConfigurationError(problem, where=where, remedy="correct this field of the rig file")
    return name, ranges[name]


def _listed(names: Sequence[str]) -> str:
    if not names:
        return "nothing, the device has none"
    return ", ".join(names) if len(names) <= 6 else f"{names[0]} to {names[-1]}"
