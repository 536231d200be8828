"""Analog output channels."""

from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.analog_inputs import as_kind
from modallab_simulators.ni_daqmx_server.calls.channel_names import assigned, split
from modallab_simulators.ni_daqmx_server.calls.kinds import settings
from modallab_simulators.ni_daqmx_server.catalogue import M_SERIES, X_SERIES
from modallab_simulators.ni_daqmx_server.output_task import IDLE_HOLD, OutputTask
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Channel

Answer = dict[str, Any]
TYPES = {"Voltage": 10322, "Current": 10134, "FuncGen": 14750}


def add_analog(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """Analog outputs."""
    task: OutputTask = as_kind(system, request.task.name, OutputTask)
    physical = split(str(request.physical_channel))
    given = settings(f"AO{kind}", "AO", request)
    for name, place in zip(assigned(str(request.name_to_assign_to_channel), physical), physical, strict=True):
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
