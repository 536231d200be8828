"""Attributes of tasks, their channels, clocks, triggers and buffers: what was set, else what the device starts with."""

import re
from collections.abc import Callable, Sequence
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as messages

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Channel, Task, terminal
from modallab_simulators.ni_daqmx_server.answers import devices, stored
from modallab_simulators.ni_daqmx_server.answers.known import COMPUTED
from modallab_simulators.ni_daqmx_server.answers.stored import default
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import split_channel_list
from modallab_simulators.ni_daqmx_server.calls.timing import IMPLICIT, ON_DEMAND, require_routes, set_rate
from modallab_simulators.ni_daqmx_server.counter_task import CounterOutputTask
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.output_task import OutputTask, WatchdogTask
from modallab_simulators.ni_daqmx_server.status import FAMILIES, ZEROS, StatusError, lookup

REGENERATE = 10097
_PER_DEVICE = ("AI_CONV", "SYNC_PULSE", "SAMP_CLK_TIMEBASE", "REF_CLK", "FIRST_SAMP_CLK")
_TERMINALS = ("_SRC", "_OUTPUT_TERM")
_NO_TERMINAL = ("EXCIT", "INPUT_SRC", "CJC", "DAC", "SHUNT", "TIMEBASE_SRC")


def chosen_channels(task: Task, which: str) -> Sequence[Channel]:
    """The channels that are meant; all where none is named.

    Raises:
        StatusError: the task has no such channel.
    """
    channels = task.all_channels()
    if not which or isinstance(task, WatchdogTask):
        return channels
    by_name = {c.name: c for c in channels} | {c.physical: c for c in channels if c.name not in channels}
    names = [which] if which in by_name else split_channel_list(which)
    for name in names:
        if name not in by_name:
            raise StatusError(status.NO_SUCH_TASK_CHANNEL, f"Channel Name: {name}")
    return [by_name[name] for name in names]


def get(server: SimulatedSystem, family: str, name: str, kind: str, task: Task, which: str) -> Any:
    """What an attribute is."""
    if family == "Watchdog":
        return _watchdog(task, which, name, kind)
    channels = chosen_channels(task, which) if family == "Channel" else ()
    channel = channels[0] if channels else None
    _require_device_context(family, name, which)
    if family == "Timing":
        require_routes(server, task)
    computed: Callable[..., Any] | None = COMPUTED.get((family, name))
    if computed is not None:
        found = computed(server, task, channel)
        if found is not None:
            return found
    stored = task.get(name, None, channel.name if channel is not None else (which if family == "Timing" else ""))
    return default(family, name, kind, task, channel) if stored is None else stored


def _require_device_context(family: str, name: str, which: str) -> None:
    if family == "Timing" and which and not name.startswith(_PER_DEVICE):
        raise StatusError(status.NO_DEVICE_CONTEXT, f"Property: {name}\nDevice: {which}")


def _watchdog(task: Task, which: str, name: str, kind: str) -> Any:
    if not isinstance(task, WatchdogTask):
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Task Name: {task.name}")
    if name == "HAS_EXPIRED":
        if not task.running:
            raise StatusError(status.NOT_CAPABLE_WHEN_IDLE, f"Property: {name}")
        return task.expired
    if name == "TIMEOUT":
        return task.timeout_s
    stored = task.get(name, None, which)
    return default("Watchdog", name, kind, task, None) if stored is None else stored


def put(server: SimulatedSystem, family: str, name: str, task: Task, which: str, value: Any) -> None:
    """Set an attribute."""
    _require_device_context(family, name, which)
    if family == "Channel":
        for channel in chosen_channels(task, which):
            _require_in_range(task, channel, name, value)
            if isinstance(task, OutputTask) and name == "AO_IDLE_OUTPUT_BEHAVIOR":
                task.set_idle(int(value))
            task.attributes[channel.name, name] = value
        if isinstance(task, CounterOutputTask):
            _retrain(task, name, value)
        return
    _apply(task, name, value)
    place = which if family in ("Watchdog", "Timing") else ""
    task.attributes[place, name] = _full(task, name, value) if family == "Timing" else value


def _apply(task: Task, name: str, value: Any) -> None:
    if name == "SAMP_CLK_RATE":
        set_rate(task, float(value))
    elif name == "SAMP_TIMING_TYPE":
        task.timing = "on-demand" if value == ON_DEMAND else "implicit" if value == IMPLICIT else "clocked"
    elif isinstance(task, AcquiringTask) and name == "INPUT_BUF_SIZE":
        task.buffer = int(value)
    elif isinstance(task, AcquiringTask) and name == "OUTPUT_BUF_SIZE":
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Property: {name}")
    elif isinstance(task, OutputTask) and name == "REGEN_MODE":
        for output in (task, *task.others):
            output.again = value == REGENERATE
    elif isinstance(task, WatchdogTask) and name == "TIMEOUT":
        task.timeout_s = float(value)


def _full(task: Task, name: str, value: Any) -> Any:
    # A terminal is kept with its device, as the device names it.
    is_terminal = name.endswith(_TERMINALS) and not any(part in name for part in _NO_TERMINAL)
    return terminal(value, task.default_device) if is_terminal and isinstance(value, str) else value


def _require_in_range(task: Task, channel: Channel, name: str, value: Any) -> None:
    if not isinstance(task, InputTask) or name not in ("AI_MAX", "AI_MIN"):
        return
    found = next(c for c in task.channels if c.name == channel.name)
    if abs(value) / abs(found.per_volt) > channel.module.input_range_v * 10:
        raise StatusError(status.INVALID_VALUE, f"Property: {name}\nRequested Value: {value}")


def _retrain(task: CounterOutputTask, name: str, value: Any) -> None:
    for channel, (frequency_hz, duty) in list(task.trains.items()):
        if name == "CO_PULSE_FREQ":
            task.trains[channel] = (float(value), duty)
        elif name == "CO_PULSE_DUTY_CYC":
            task.trains[channel] = (frequency_hz, float(value))


def reset(server: SimulatedSystem, family: str, name: str, task: Task, which: str) -> None:
    """Back to what the device starts with."""
    _require_device_context(family, name, which)
    if family == "Channel":
        for channel in chosen_channels(task, which):
            task.attributes.pop((channel.name, name), None)
        return
    if name == "SAMP_CLK_RATE":
        set_rate(task, default("Timing", name, "Double", task, None))
    elif name == "INPUT_BUF_SIZE" and isinstance(task, AcquiringTask):
        task.buffer = 0
    task.attributes.pop((which if family in ("Watchdog", "Timing") else "", name), None)
    if isinstance(task, WatchdogTask) and name == "TIMEOUT":
        task.timeout_s = 10.0


CALL = re.compile(
    r"(Get|Set|Reset)(SystemInfo|Task|Chan|Read|Write|TimingEx|Timing|Buffer|Device|PhysicalChan|Watchdog|Trig|"
    r"ExportedSignal|Scale|CalInfo|RealTime|PersistedTask|PersistedChan|PersistedScale)Attribute(Ex)?(\w*)"
)
_MESSAGES: Any = messages
EPOCH_1904_S = -2_082_844_800
"""What a time is that was never set, in s of the wire's own epoch."""


def attribute(system: SimulatedSystem, call: str, match: "re.Match[str]", request: Any) -> Any:
    """The answer to a call that reads, sets or resets an attribute.

    Raises:
        StatusError: there is no such attribute here, or it cannot have this value.
    """
    verb, group, _, kind = match.groups()
    family = FAMILIES.get(group, group)
    number = request.attribute_raw or request.attribute
    name, _ = lookup(family, number)
    if not name:
        raise StatusError(status.ATTRIBUTE_UNKNOWN, f"Property: {number:#x}")
    response = getattr(_MESSAGES, f"{call}Response")()
    if verb == "Get":
        _fill(response, kind, _get(system, family, name, kind, request))
    elif verb == "Set":
        _set(system, family, name, request, _given(request))
    elif hasattr(request, "task"):
        task = system.task(request.task.name, Task)
        reset(system, family, name, task, _which(request))
    return response


def _which(request: Any) -> str:
    for field in ("channel", "device_names", "lines"):
        if hasattr(request, field):
            return str(getattr(request, field)).replace(" ,", ",")
    return ""


def _given(request: Any) -> Any:
    value = getattr(request, "value_raw", None)
    value = value or request.value
    return list(value) if hasattr(value, "append") else value


def _get(system: SimulatedSystem, family: str, name: str, kind: str, request: Any) -> Any:
    if family == "System":
        return devices.system(system, name)
    if family == "Device":
        return devices.device(system, request.device_name, name, ZEROS[kind])
    if family == "PhysicalChannel":
        return devices.physical(system, request.physical_channel, name)
    if family == "Scale":
        return stored.scale(system, request.scale_name, name)
    if family == "CalibrationInfo":
        return stored.calibration(system, request.device_name, name)
    if family.startswith("Persisted"):
        which = next(getattr(request, f) for f in ("task_name", "channel", "scale_name") if hasattr(request, f))
        return stored.saved(system, family, which, name)
    return get(system, family, name, kind, system.task(request.task.name, Task), _which(request))


def _set(system: SimulatedSystem, family: str, name: str, request: Any, value: Any) -> None:
    if family == "Scale":
        stored.put_scale(system, request.scale_name, name, value)
    elif family == "CalibrationInfo":
        system.notes[request.device_name] = str(value)
    else:
        put(system, family, name, system.task(request.task.name, Task), _which(request), value)


def _fill(response: Any, kind: str, value: Any) -> None:
    if kind == "Timestamp":
        if value is None:
            response.value.seconds = EPOCH_1904_S
        else:
            response.value.CopyFrom(value)
    elif kind.endswith("Array"):
        field = response.value_raw if hasattr(response, "value_raw") else response.value
        field.extend(value)
    elif kind == "Int32":
        response.value_raw = value
    else:
        response.value = value
