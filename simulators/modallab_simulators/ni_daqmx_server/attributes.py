"""Attributes, which on the wire are one family of calls: what each object answers to which number."""

from collections.abc import Callable
from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.modules import CHASSIS, Module
from modallab_simulators.ni_daqmx_server.output_task import DELTA_SIGMA, LineTask, OutputTask, WatchdogTask
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Task

ANALOG_INPUT, ANALOG_OUTPUT, DIGITAL_OUTPUT = 10100, 10102, 10153

_SYSTEM: dict[int, Callable[[SimulatedSystem], Any]] = {
    0x1272: lambda s: 25,
    0x1923: lambda s: 0,
    0x2F22: lambda s: 0,
    0x193B: lambda s: ", ".join(([CHASSIS] if s.chassis else []) + list(s.modules)),
}

_DEVICE: dict[int, Callable[[Module], Any]] = {
    0x631: lambda m: m.product,
    0x632: lambda m: m.serial,
    0x231E: lambda m: ", ".join(m.input_names()),
    0x231F: lambda m: ", ".join(m.output_names()),
    0x2324: lambda m: ", ".join(m.line_names()),
    0x2990: lambda m: [-m.input_range_v, m.input_range_v] if m.inputs else [],
    0x299B: lambda m: [-m.output_range_v, m.output_range_v] if m.outputs else [],
    0x298C: lambda m: m.max_rate_hz,
    0x298D: lambda m: m.max_rate_hz,
    0x298E: lambda m: m.min_rate_hz,
    0x2997: lambda m: m.max_rate_hz,
    0x22CA: lambda m: False,
    0x29B6: lambda m: "",
    0x29CB: lambda m: list(m.supplies_a),
}

_CHASSIS: dict[int, Callable[[SimulatedSystem], Any]] = {
    0x631: lambda s: s.chassis,
    0x632: lambda s: 0x0C0DE,
    0x29B6: lambda s: ", ".join(s.modules),
    0x22CA: lambda s: False,
}


def system(server: SimulatedSystem, number: int) -> Any:
    """An attribute of the whole system."""
    return _answer(_SYSTEM, number, server)


def device(server: SimulatedSystem, name: str, number: int) -> Any:
    """An attribute of a device or chassis."""
    if name in server.reserved.gone:
        raise StatusError(server.reserved.gone[name], f"Device: {name}")
    if name == CHASSIS and server.chassis:
        # A chassis has no channels of its own.
        return _answer(_CHASSIS, number, server) if number in _CHASSIS else ""
    return _answer(_DEVICE, number, server.module_of(name))


def physical_channel(server: SimulatedSystem, name: str, number: int) -> Any:
    """An attribute of an input or output: the serial number in the data sheet of its sensor."""
    server.module_of(name)
    serial = server.rig.channels[server.row_of(name)].serial
    if number != 0x21DC or not serial.isdecimal():
        raise StatusError(status.NO_TEDS, f"Physical Channel: {name}")
    return int(serial)


def task(server: SimulatedSystem, name: str, number: int) -> Any:
    """An attribute of a task."""
    found = server.task(name, Task)
    channels = [c.physical for c in found.channels] if isinstance(found, InputTask) else _output_channels(found)
    answers = {0x1276: found.name, 0x1273: ", ".join(channels), 0x2181: len(channels)}
    if number not in answers:
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Property: {number:#x}")
    return answers[number]


def channel(server: SimulatedSystem, name: str, which: str, number: int) -> Any:
    """An attribute of a channel of a task."""
    found = server.task(name, Task)
    if (which, number) in found.attributes:
        return found.attributes[which, number]
    if number == 0x187F:
        if isinstance(found, InputTask):
            return ANALOG_INPUT
        return ANALOG_OUTPUT if isinstance(found, OutputTask) else DIGITAL_OUTPUT
    if number == 0x1108:
        return 10322
    if number == 0x2240 and isinstance(found, OutputTask) and found.product in DELTA_SIGMA:
        return found.idle
    if isinstance(found, InputTask) and number in (0x2FED, 0x1815):
        chosen = next(c for c in found.channels if which in (c.physical, ""))
        return chosen.module.delay_samples / found.rate_hz if number == 0x2FED else chosen.module.input_range_v
    raise StatusError(status.NOT_SUPPORTED_HERE, f"Property: {number:#x}\nChannel: {which}")


def timing(server: SimulatedSystem, name: str, number: int) -> Any:
    """An attribute of a task's clock."""
    found = server.task(name, Task)
    if number == 0x1344 and isinstance(found, InputTask | OutputTask):
        return found.rate_hz
    if number == 0x1848 and isinstance(found, InputTask) and any(m.multiplexed for m in found.modules):
        return found.convert_rate_hz()
    raise StatusError(status.NOT_SUPPORTED_HERE, f"Property: {number:#x}")


def read(server: SimulatedSystem, name: str, number: int) -> Any:
    """An attribute of a task's reading end. Asking whether there is an overload clears the flags."""
    found = server.task(name, InputTask)
    names = [c.physical for c in found.channels]
    if number == 0x2174:
        overloaded = [n for n, flag in zip(names, found.overload, strict=True) if flag]
        found.attributes["", 0x2175] = ", ".join(overloaded)
        found.overload[:] = False
        return bool(overloaded)
    answers: dict[int, Any] = {
        0x2175: found.attributes.get(("", 0x2175), ""),
        0x3100: bool(found.dead),
        0x3101: ", ".join(names[n] for n in sorted(found.dead)),
        0x3088: bool(found.attributes.get(("", -1), False)),
        0x3089: "",
        0x217B: len(names),
        0x31E8: found.finite,
        0x192A: found.acquired(server.clock),
        0x1223: found.acquired(server.clock) - found.position,
        0x1221: found.position,
    }
    return _known(answers, number)


def write(server: SimulatedSystem, name: str, number: int) -> Any:
    """An attribute of a task's writing end."""
    found = server.task(name, Task)
    if isinstance(found, OutputTask):
        answers = {0x217E: 1, 0x1453: 10097 if found.again else 10158, 0x192B: found.played(server.clock)}
        return _known(answers, number)
    return _known({0x217E: 1, 0x217F: 1}, number)


def watchdog(server: SimulatedSystem, name: str, number: int) -> Any:
    """An attribute of a watchdog."""
    found = server.task(name, WatchdogTask)
    return _known({0x21A8: found.expired, 0x21A9: found.timeout_s}, number)


def put(server: SimulatedSystem, name: str, which: str, number: int, value: Any) -> None:
    """Set an attribute of a task or of a channel of it."""
    found = server.task(name, Task)
    if isinstance(found, InputTask) and number == 0x186C:
        found.buffer = int(value)
    elif isinstance(found, OutputTask) and number == 0x1453:
        found.again = value == 10097
    elif isinstance(found, OutputTask) and number == 0x2240:
        found.set_idle(int(value))
    elif isinstance(found, WatchdogTask) and number == 0x21A9:
        found.timeout_s = float(value)
    found.attributes[which, number] = value


def _output_channels(found: Task) -> list[str]:
    if isinstance(found, LineTask):
        return list(found.lines)
    return [found.physical] if isinstance(found, OutputTask) else []


def _known(answers: dict[int, Any], number: int) -> Any:
    if number not in answers:
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Property: {number:#x}")
    return answers[number]


def _answer(table: dict[int, Callable[[Any], Any]], number: int, target: Any) -> Any:
    if number not in table:
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Property: {number:#x}")
    return table[number](target)
