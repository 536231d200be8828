"""Digital, analog output and counter channels."""

from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import Channel
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.analog_inputs import as_kind
from modallab_simulators.ni_daqmx_server.calls.kinds import MEASURES, channel_names, settings, split_channel_list
from modallab_simulators.ni_daqmx_server.counter_task import (
    TICKS_HZ,
    CounterInputTask,
    CounterOutputTask,
    DigitalInputTask,
    LineTask,
)
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.output_task import IDLE_HOLD, OutputTask
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.systems import M_SERIES, X_SERIES

Answer = dict[str, Any]


def lines_of(system: SimulatedSystem, name: str) -> list[str]:
    """The lines of a port, or the line itself.

    Raises:
        StatusError: there is neither.
    """
    module = system.module_of(name)
    if name in module.line_names():
        return [name]
    found = [line for line in module.line_names() if line.startswith(f"{name}/")]
    if not found:
        raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {name}")
    return found


def _channels(system: SimulatedSystem, request: Any) -> list[Channel]:
    listed = split_channel_list(str(request.lines))
    groups = [(name, lines_of(system, name)) for name in listed]
    module = system.module_of(listed[0])
    if request.line_grouping_raw or request.line_grouping:
        lines = [line for _, found in groups for line in found]
        name = request.name_to_assign_to_lines or (listed[0] if len(listed) == 1 else f"{listed[0]}...")
        return [Channel(name, ",".join(lines), module, _order(groups))]
    names = channel_names(str(request.name_to_assign_to_lines), listed)
    if all(lines == [name] for name, lines in groups):
        return [Channel(n, lines[0], module) for n, (_, lines) in zip(names, groups, strict=True)]
    return [Channel(line, line, module) for _, lines in groups for line in lines]


def _order(groups: list[tuple[str, list[str]]]) -> tuple[int, ...]:
    found: list[int] = []
    for name, lines in groups:
        places = range(len(found), len(found) + len(lines))
        found += places if lines == [name] else reversed(places)
    return tuple(found)


def add_inputs(system: SimulatedSystem, request: Any) -> Answer:
    """Lines to be read."""
    task: DigitalInputTask = as_kind(system, request.task.name, DigitalInputTask)
    task.channels += _channels(system, request)
    task.level = system.level
    return {}


def add_outputs(system: SimulatedSystem, request: Any) -> Answer:
    """Lines to be set."""
    task: LineTask = as_kind(system, request.task.name, LineTask)
    task.channels += _channels(system, request)
    task.levels = system.levels_of_lines
    task.resources |= set(task.lines)
    return {}


TYPES = {"Voltage": 10322, "Current": 10134, "FuncGen": 14750}


def add_analog(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """Analog outputs."""
    task: OutputTask = as_kind(system, request.task.name, OutputTask)
    physical = split_channel_list(str(request.physical_channel))
    given = settings(f"AO{kind}", "AO", request)
    for name, place in zip(channel_names(str(request.name_to_assign_to_channel), physical), physical, strict=True):
        module = system.module_of(place)
        if place not in module.output_names():
            raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {place}")
        highest = max(abs(given.get("AO_MIN", 0.0)), abs(given.get("AO_MAX", 0.0)))
        if kind == "Voltage" and highest > module.output_range_v * (1 + 1e-9):
            raise StatusError(status.INVALID_VALUE, f"Property: AO.Max\nRequested Value: {highest}")
        output = task
        if task.physical:
            output = OutputTask(task.name)
            task.others.append(output)
        output.physical, output.line = place, system.lines[place]
        output.needs_clock = module.delta_sigma
        output.held_steps = module.category in (X_SERIES, M_SERIES)
        task.channels.append(Channel(name, place, module))
        task.resources.add(place)
        for attribute, value in given.items():
            task.attributes[name, attribute] = value
        task.attributes[name, "AO_OUTPUT_TYPE"] = TYPES[kind]
        task.attributes[name, "AO_IDLE_OUTPUT_BEHAVIOR"] = IDLE_HOLD
    return {}


OUTPUT_TYPES = {"PulseFreq": 10119, "PulseTime": 10269, "PulseTicks": 10268}


def _module(system: SimulatedSystem, counter: str) -> Module:
    name, _, rest = counter.partition("/")
    if name in system.chassis and rest.startswith("_ctr"):
        # A chassis has counters of its own, which are named by an underscore.
        return next(m for m in system.modules.values() if m.chassis == name)
    module = system.module_of(counter)
    if counter not in module.counter_names() and not rest.startswith("_"):
        raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {counter}")
    return module


def add_measuring(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """Counters that measure."""
    task: CounterInputTask = as_kind(system, request.task.name, CounterInputTask)
    task.kind, task.pulses = kind, system.pulses
    physical = split_channel_list(str(request.counter))
    for name, place in zip(channel_names(str(request.name_to_assign_to_channel), physical), physical, strict=True):
        task.channels.append(Channel(name, place, _module(system, place)))
        task.resources.add(place)
        for attribute, value in settings(kind, "CI", request).items():
            task.attributes[name, attribute] = value
        task.attributes[name, "CI_MEAS_TYPE"] = MEASURES[kind][0]
    return {}


def add_generating(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """Counters that give out pulses."""
    task: CounterOutputTask = as_kind(system, request.task.name, CounterOutputTask)
    physical = split_channel_list(str(request.counter))
    for name, place in zip(channel_names(str(request.name_to_assign_to_channel), physical), physical, strict=True):
        channel = Channel(name, place, _module(system, place))
        task.channels.append(channel)
        task.resources.add(place)
        for attribute, value in settings(f"CO{kind}", "CO", request).items():
            task.attributes[name, attribute] = value
        task.attributes[name, "CO_OUTPUT_TYPE"] = OUTPUT_TYPES[kind]
        task.trains[name] = _train(request, kind)
    return {}


def _train(request: Any, kind: str) -> tuple[float, float]:
    if kind == "PulseFreq":
        return request.freq, request.duty_cycle
    high, low = (
        (request.high_time, request.low_time)
        if kind == "PulseTime"
        else (request.high_ticks / TICKS_HZ, request.low_ticks / TICKS_HZ)
    )
    return train(high, low)


def train(high_s: float, low_s: float) -> tuple[float, float]:
    """Frequency and duty cycle of pulses by their times."""
    return 1 / (high_s + low_s), high_s / (high_s + low_s)
