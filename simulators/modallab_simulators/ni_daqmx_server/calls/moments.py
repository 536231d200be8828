"""Times of triggers and clocks, as a device stamps them."""

from functools import partial
from time import time
from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Task

Answer = dict[str, Any]
_STAMPS = {12491: "START_TRIG", 12490: "REF_TRIG", 14641: "ARM_START_TRIG", 16130: "FIRST_SAMP"}


def get(system: SimulatedSystem, request: Any, attribute: str) -> Answer:
    """A time that was set."""
    found = system.task(request.task.name, Task).get(attribute)
    return {} if found is None else {"data": found}


def put(system: SimulatedSystem, request: Any, attribute: str) -> Answer:
    """Set a time."""
    system.task(request.task.name, Task).attributes["", attribute] = request.data
    return {}


def wait(system: SimulatedSystem, request: Any) -> Answer:
    """The time at which a device saw an event.

    Raises:
        StatusError: it was not asked to stamp it.
    """
    task = system.task(request.task.name, Task)
    name = _STAMPS.get(request.timestamp_event_raw or request.timestamp_event, "FIRST_SAMP")
    # The first sample is stamped by devices that keep the time unless that is switched off.
    if not task.get(f"{name}_TIMESTAMP_ENABLE", name == "FIRST_SAMP"):
        raise StatusError(status.NO_TIMESTAMP, f"Task Name: {task.name}")
    task.attributes["", f"{name}_TIMESTAMP_ENABLE"] = True
    return {"timestamp": _now(request)}


def _now(request: Any) -> Any:
    from google.protobuf.timestamp_pb2 import Timestamp

    stamp = Timestamp()
    stamp.FromNanoseconds(int(time() * 1e9))
    return stamp


MOMENTS: dict[str, Any] = {"WaitForValidTimestamp": wait}
for _call, _name in {
    "ArmStartTrigTrigWhen": "ARM_START_TRIG_TRIG_WHEN", "FirstSampClkWhen": "FIRST_SAMP_CLK_WHEN",
    "StartTrigTrigWhen": "START_TRIG_TRIG_WHEN", "SyncPulseTimeWhen": "SYNC_PULSE_TIME_WHEN",
}.items():  # fmt: skip
    MOMENTS[f"Get{_call}"] = partial(get, attribute=_name)
    MOMENTS[f"Set{_call}"] = partial(put, attribute=_name)
for _call, _name in {
    "ArmStartTrigTimestampVal": "ARM_START_TRIG_TIMESTAMP_VAL", "FirstSampTimestampVal": "FIRST_SAMP_TIMESTAMP_VAL",
    "RefTrigTimestampVal": "REF_TRIG_TIMESTAMP_VAL", "StartTrigTimestampVal": "START_TRIG_TIMESTAMP_VAL",
}.items():  # fmt: skip
    MOMENTS[f"Get{_call}"] = partial(get, attribute=_name)
