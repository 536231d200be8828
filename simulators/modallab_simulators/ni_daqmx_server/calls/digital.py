"""Digital channels: ports, lines, one channel for all lines or one for each."""

from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.analog_inputs import as_kind
from modallab_simulators.ni_daqmx_server.calls.channel_names import assigned, split
from modallab_simulators.ni_daqmx_server.digital_task import DigitalInputTask
from modallab_simulators.ni_daqmx_server.line_task import LineTask
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Channel

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
    listed = split(str(request.lines))
    groups = [(name, lines_of(system, name)) for name in listed]
    module = system.module_of(listed[0])
    if request.line_grouping_raw or request.line_grouping:
        lines = [line for _, found in groups for line in found]
        name = request.name_to_assign_to_lines or (listed[0] if len(listed) == 1 else f"{listed[0]}...")
        return [Channel(name, ",".join(lines), module, _order(groups))]
    names = assigned(str(request.name_to_assign_to_lines), listed)
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
