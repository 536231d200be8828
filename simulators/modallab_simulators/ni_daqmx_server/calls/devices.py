"""Devices: reset, test, calibration; scales and what is saved; watchdogs."""

import time
from typing import Any

import numpy as np

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.answers.stored import write_scale
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import split_channel_list
from modallab_simulators.ni_daqmx_server.calls.sessions import session
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.output_task import WatchdogTask
from modallab_simulators.ni_daqmx_server.status import StatusError, describe

Answer = dict[str, Any]


def create_watchdog(system: SimulatedSystem, request: Any) -> Answer:
    """A watchdog on a device that has one."""
    name = request.device_name
    system.require_device(name)
    if not system.chassis and not system.modules[name].simulated:
        raise StatusError(status.NO_WATCHDOG, f"Device: {name}")
    found, new = session(system, request)
    if new:
        system.add(WatchdogTask(found, device=name, timeout_s=request.timeout))
    return {"task": found, "new_session_initialized": new}


def set_watchdog_states(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """Where outputs go when the watchdog expires."""
    task = system.task(request.task.name, WatchdogTask)
    names = split_channel_list(str(request.channel_names))
    states = list(request.expir_state_array) or list(getattr(request, "expir_state_array_raw", []))
    for place, name in enumerate(names):
        if kind == "AO" and name not in system.lines:
            raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {name}")
        task.attributes[name, f"{kind}_EXPIR_STATE"] = states[place]
    if kind == "AO":
        kinds = list(getattr(request, "output_type_array_raw", [])) or list(request.output_type_array)
        task.states = dict(zip(names, states, strict=True))
        for name, output in zip(names, kinds, strict=False):
            task.attributes[name, "AO_OUTPUT_TYPE"] = output
    return {}


def control_watchdog(system: SimulatedSystem, request: Any) -> Answer:
    """Reset the timer, or clear what has expired. A chassis wants to be reset itself then: to clear is not enough."""
    task = system.task(request.task.name, WatchdogTask)
    clears = request.action_raw == 1 or request.action == 1
    if task.expired and not clears:
        raise StatusError(status.EXPIRED_NOT_RESET, f"Task Name: {task.name}")
    if clears and task.device not in system.expired:
        system.resume_outputs(task)
    if not task.expired:
        task.kick(time.monotonic())
    return {}


def shunt(system: SimulatedSystem, request: Any) -> Answer:
    """Switch a shunt resistor onto a bridge and take it off again: the gain it gives is kept in the channel."""
    task = system.task(request.task.name, InputTask)
    for channel in task.channels:
        if not channel.module.bridge:
            raise StatusError(status.NOT_SUPPORTED_HERE, f"Channel: {channel.physical}")
    return {}


def null(system: SimulatedSystem, request: Any) -> Answer:
    """Take the offset of bridges or thermocouple leads into account."""
    system.task(request.task.name, InputTask)
    return {}


def reset_device(system: SimulatedSystem, request: Any) -> Answer:
    """Abort everything on a device."""
    system.reset(request.device_name)
    return {}


def self_test(system: SimulatedSystem, request: Any) -> Answer:
    """A device that is there passes."""
    system.require_device(request.device_name)
    return {}


def calibrated_at(system: SimulatedSystem, request: Any) -> Answer:
    """When a device was calibrated."""
    system.require_device(request.device_name)
    return {"year": 2025, "month": 3, "day": 14, "hour": 9, "minute": 26}


def supports_calibration(system: SimulatedSystem, request: Any) -> Answer:
    """Whether a device can be calibrated."""
    system.require_device(request.device_name)
    return {"cal_supported": True}


def error_string(system: SimulatedSystem, request: Any) -> Answer:
    """The text of a code."""
    return {"error_string": describe(request.error_code)}


def make_scale(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """A scale of this session."""
    write_scale(system.saved.scales, request, kind)
    return {}


def reverse_coefficients(system: SimulatedSystem, request: Any) -> Answer:
    """The polynomial that undoes another, by least squares over its range."""
    points = max(int(request.num_points_to_compute), 10)
    values = np.linspace(request.min_val_x, request.max_val_x, points)
    scaled = np.polynomial.polynomial.polyval(values, list(request.forward_coeffs))
    order = request.reverse_poly_order if request.reverse_poly_order >= 0 else len(request.forward_coeffs) - 1
    return {"reverse_coeffs": list(np.polynomial.polynomial.polyfit(scaled, values, order))}


def delete(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """Forget what was saved."""
    known: dict[str, Any] = {
        "Scale": system.saved.scales, "Task": system.saved.tasks, "Channel": system.saved.channels,
    }[kind]  # fmt: skip
    name = request.scale_name if kind == "Scale" else request.task_name if kind == "Task" else request.channel_name
    known.pop(name, None)
    return {}


def configure_logging(system: SimulatedSystem, request: Any) -> Answer:
    """Write what is read into a file of the server's, too."""
    task = system.task(request.task.name, InputTask)
    task.attributes["", "LOGGING_FILE_PATH"] = request.file_path
    task.attributes["", "LOGGING_MODE"] = request.logging_mode_raw or request.logging_mode
    task.attributes["", "LOGGING_TDMS_GROUP_NAME"] = request.group_name
    task.attributes["", "LOGGING_TDMS_OPERATION"] = request.operation_raw or request.operation
    return {}


def start_new_file(system: SimulatedSystem, request: Any) -> Answer:
    """Log into another file from now on."""
    system.task(request.task.name, InputTask).attributes["", "LOGGING_FILE_PATH"] = request.file_path
    return {}


def save_channel(system: SimulatedSystem, request: Any) -> Answer:
    """Keep an analog input channel of a task."""
    task = system.task(request.task.name, InputTask)
    channel = next(c for c in task.channels if c.name == request.channel_name)
    system.saved.channels[request.save_as or channel.name] = {
        "ChanType": "Analog Input", "AI.MeasType": "Voltage", "AI.TermCfg": "Differential",
        "AI.Min": str(channel.low), "AI.Max": str(channel.high), "PhysicalChanName": channel.physical,
        "Author": request.author,
        "AllowInteractiveEditing": str(bool(request.options_raw & 2 or request.options & 2)),
    }  # fmt: skip
    return {}


def nothing(system: SimulatedSystem, request: Any) -> Answer:
    """Accepted, and without a consequence on the bench."""
    return {}
