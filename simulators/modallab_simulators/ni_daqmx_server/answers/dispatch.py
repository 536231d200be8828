"""Attributes on the wire are one family of calls: each by the group in its name, the number, and the type."""

import re
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as messages

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.answers import devices, stored, tasks
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.names import FAMILIES, ZEROS, lookup
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Task

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
        tasks.reset(system, family, name, task, _which(request))
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
    return tasks.get(system, family, name, kind, system.task(request.task.name, Task), _which(request))


def _set(system: SimulatedSystem, family: str, name: str, request: Any, value: Any) -> None:
    if family == "Scale":
        stored.put_scale(system, request.scale_name, name, value)
    elif family == "CalibrationInfo":
        system.notes[request.device_name] = str(value)
    else:
        tasks.put(system, family, name, system.task(request.task.name, Task), _which(request), value)


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
