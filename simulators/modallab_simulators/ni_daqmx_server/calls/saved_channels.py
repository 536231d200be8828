"""Saved channels, made again in a task."""

from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as messages

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.analog_inputs import add_inputs
from modallab_simulators.ni_daqmx_server.calls.outputs import add_analog
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Task

_MESSAGES: Any = messages
_TERMINALS = {"Differential": 10106, "RSE": 10083, "NRSE": 10078, "PseudoDifferential": 12529}
VOLTS = 10348


def add_saved(system: SimulatedSystem, task: str, names: list[str]) -> None:
    """Add saved channels to a task.

    Raises:
        StatusError: there is no such channel.
    """
    for name in names:
        if name not in system.saved.channels:
            raise StatusError(status.NO_SUCH_GLOBAL_CHANNEL, f"Channel Name: {name}")
        section = system.saved.channels[name]
        output = section["ChanType"] == "Analog Output"
        request = (_MESSAGES.CreateAOVoltageChanRequest if output else _MESSAGES.CreateAIVoltageChanRequest)()
        request.task.name = task
        request.physical_channel = section["PhysicalChanName"]
        request.name_to_assign_to_channel = name.rpartition("/")[2]
        request.min_val = float(section["AO.Min" if output else "AI.Min"])
        request.max_val = float(section["AO.Max" if output else "AI.Max"])
        request.units_raw = VOLTS
        if output:
            add_analog(system, request, "Voltage")
        else:
            request.terminal_config_raw = _TERMINALS[section["AI.TermCfg"]]
            add_inputs(system, request, "Voltage")
    system.task(task, Task).attributes["", "GLOBAL"] = True
