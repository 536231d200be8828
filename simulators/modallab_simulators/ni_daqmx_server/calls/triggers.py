"""Start, reference and other triggers, and signals that leave a device."""

from functools import partial
from time import time
from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import Task, terminal
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import fields_of
from modallab_simulators.ni_daqmx_server.calls.timing import require_terminal
from modallab_simulators.ni_daqmx_server.input_task import InputTask, ReferenceTrigger
from modallab_simulators.ni_daqmx_server.status import StatusError

Answer = dict[str, Any]

RISING, NONE = 10280, 10230
TYPES = {"ANLG_EDGE": 10099, "DIG_EDGE": 10150, "ANLG_WIN": 10103, "DIG_PATTERN": 10398, "ANLG_MULTI_EDGE": 16108}
_FIELDS = {
    "trigger_source": "SRC", "trigger_slope": "SLOPE", "trigger_level": "LVL", "trigger_edge": "EDGE",
    "trigger_when": "WHEN", "window_top": "TOP", "window_bottom": "BTM", "trigger_pattern": "PATTERN",
    "trigger_sources": "SRCS", "trigger_slope_array": "SLOPES", "trigger_level_array": "LVLS",
}  # fmt: skip


def configure(system: SimulatedSystem, request: Any, kind: str, place: str) -> Answer:
    """A trigger of a kind such as DIG_EDGE at START or REF."""
    task = system.task(request.task.name, Task)
    given = fields_of(request)
    if place == "REF" and isinstance(task, InputTask):
        _set_reference(task, given, kind)
    for field, value in given.items():
        if field in _FIELDS:
            full = field == "trigger_source" and kind != "DIG_PATTERN" and "/" not in value
            task.attributes["", f"{kind}_{place}_TRIG_{_FIELDS[field]}"] = (
                terminal(value, task.default_device) if full else value
            )
    if "pretrigger_samples" in given:
        task.attributes["", "REF_TRIG_PRETRIG_SAMPLES"] = given["pretrigger_samples"]
    task.attributes["", f"{place}_TRIG_TYPE"] = TYPES[kind]
    return {}


def _set_reference(task: InputTask, given: dict[str, Any], kind: str) -> None:
    if kind == "DIG_EDGE":
        _require_finite(task)
        task.trigger = ReferenceTrigger(-1, 0.0, rising=True, pre_trigger=given["pretrigger_samples"])
        return
    if kind != "ANLG_EDGE":
        return
    names = [name for c in task.channels for name in (c.physical, c.name)]
    source = str(given["trigger_source"])
    if source in names:
        _require_finite(task)
        rising = given["trigger_slope"] == RISING
        channel = names.index(source) // 2
        task.trigger = ReferenceTrigger(channel, given["trigger_level"], rising, given["pretrigger_samples"])
    elif not source.rpartition("/")[2].upper().startswith("APFI"):
        raise StatusError(status.BAD_TRIGGER_SOURCE, f"Source: {source}")


def _require_finite(task: InputTask) -> None:
    if not task.finite:
        raise StatusError(status.NOT_SUPPORTED_HERE, "Property: RefTrig.Type")


def disable(system: SimulatedSystem, request: Any, place: str) -> Answer:
    """No trigger."""
    task = system.task(request.task.name, Task)
    task.attributes["", f"{place}_TRIG_TYPE"] = NONE
    if place == "REF" and isinstance(task, InputTask):
        task.trigger = None
    return {}


def at_time(system: SimulatedSystem, request: Any) -> Answer:
    """Start at a time."""
    task = system.task(request.task.name, Task)
    task.attributes["", "START_TRIG_TYPE"] = 15996
    task.attributes["", "START_TRIG_TRIG_WHEN"] = request.when
    task.attributes["", "START_TRIG_TIMESCALE"] = request.timescale_raw or request.timescale
    return {}


_SIGNALS = {
    12484: "AI_CONV_CLK", 12536: "10_MHZ_REF_CLK", 12486: "20_MHZ_TIMEBASE", 12487: "SAMP_CLK", 12488: "ADV_TRIG",
    12490: "REF_TRIG", 12491: "START_TRIG", 12492: "ADV_CMPLT_EVENT", 12493: "AI_HOLD_CMPLT_EVENT",
    12494: "CTR_OUT_EVENT", 12511: "CHANGE_DETECT_EVENT", 12512: "WATCHDOG_EXPIRED_EVENT",
}  # fmt: skip


def export(system: SimulatedSystem, request: Any) -> Answer:
    """Give a signal of a task out at a terminal."""
    require_terminal(system, request.output_terminal)
    task = system.task(request.task.name, Task)
    signal = _SIGNALS.get(request.signal_id_raw or request.signal_id)
    if signal is None:
        raise StatusError(status.INVALID_VALUE, f"Signal: {request.signal_id_raw or request.signal_id}")
    task.attributes["", f"{signal}_OUTPUT_TERM"] = request.output_terminal
    return {}


def connect(system: SimulatedSystem, request: Any) -> Answer:
    """Route one terminal to another.

    Raises:
        StatusError: there is no such terminal.
    """
    require_terminal(system, request.source_terminal)
    destination = request.destination_terminal
    try:
        require_terminal(system, destination)
    except StatusError as error:
        raise StatusError(status.NO_SUCH_DESTINATION, f"Destination Terminal: {destination}") from error
    found = system.pulses(request.source_terminal)
    if found is not None:
        system.connected[destination] = found
    return {}


def disconnect(system: SimulatedSystem, request: Any) -> Answer:
    """Take a route away again."""
    require_terminal(system, request.source_terminal)
    require_terminal(system, request.destination_terminal)
    system.connected.pop(request.destination_terminal, None)
    return {}


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
