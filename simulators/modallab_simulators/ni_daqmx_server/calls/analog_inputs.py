"""Analog input channels of every kind."""

from typing import Any

from modallab.core.units import STANDARD_GRAVITY
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import Task
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import (
    MEASURES,
    channel_names,
    fields_of,
    settings,
    split_channel_list,
)
from modallab_simulators.ni_daqmx_server.input_task import InputChannel, InputTask
from modallab_simulators.ni_daqmx_server.max_config import scaling
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.teds import sheet_of

Answer = dict[str, Any]

MILLIVOLTS = (12509, 15891)
METRES, CUSTOM = 12470, 10065
DEFAULT_TERMINALS = -1
DIFFERENTIAL, PSEUDO = 10106, 12529
INTERNAL = 10200
LET_CHOOSE, EXTERNAL = -1, 10167
_SENSORS = ("Accel", "ForceIEPE", "Microphone", "VelocityIEPE")
_ANY = ("Voltage", "Power", "CalculatedPower")
"""What the driver makes of volts on any device."""
DUPLICATE_CHANNEL = -200489


def as_kind(system: SimulatedSystem, name: str, kind: Any) -> Any:
    """The task as one of a kind; it has none before its first channel.

    Raises:
        StatusError: its channels are of another kind.
    """
    task = system.task(name, Task)
    if type(task) is Task:
        made = kind(name)
        made.events, made.attributes = task.events, task.attributes
        return system.add(made)
    if not isinstance(task, kind):
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Task Name: {name}")
    return task


def add_inputs(system: SimulatedSystem, request: Any, call: str) -> Answer:
    """Channels of the kind that a call names, such as `Accel`."""
    kind = _base(call)
    task: InputTask = as_kind(system, request.task.name, InputTask)
    listed = request.voltage_physical_channel if call == "CalculatedPower" else request.physical_channel
    physical = split_channel_list(str(listed))
    names = channel_names(str(request.name_to_assign_to_channel), physical)
    given = settings(kind, "AI", request)
    for name, place in zip(names, physical, strict=True):
        module = _require(system, place, call)
        if any(name == c.name for c in task.channels):
            raise StatusError(DUPLICATE_CHANNEL, f"Physical Channel: {place}")
        channel = _channel(system, request, name, place, module, kind, given)
        task.channels.append(channel)
        for attribute, value in given.items():
            task.attributes[name, attribute] = value
        task.attributes[name, "AI_MEAS_TYPE"] = MEASURES[kind][0]
        if "AI_TERM_CFG" in given and given["AI_TERM_CFG"] in (0, DEFAULT_TERMINALS):
            task.attributes[name, "AI_TERM_CFG"] = PSEUDO if module.delta_sigma and module.iepe else DIFFERENTIAL
        _choose_shunt(task, name, module)
        _scale_type(task, name, call)
        task.resources.add(f"{module.name}/ai")
    system.clocks.require_one_task(task.modules)
    return {}


def _base(call: str) -> str:
    for ending in ("Polynomial", "Table", "TwoPointLin"):
        call = call.removesuffix(ending)
    return call


def _require(system: SimulatedSystem, physical: str, call: str) -> Module:
    module = system.module_of(physical)
    internal = physical.partition("/")[2]
    known = physical in module.input_names() or internal.startswith("_") or internal in ("power", "dmm")
    if not known:
        raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {physical}")
    if not internal.startswith("_") and _base(call) not in (*module.measures, *_ANY):
        raise StatusError(status.WRONG_MEASUREMENT, f"Physical Channel: {physical}\nProduct: {module.product}")
    return module


def _channel(  # each is one fact of a channel
    system: SimulatedSystem, request: Any, name: str, physical: str, module: Module, kind: str, given: dict[str, Any]
) -> InputChannel:
    low, high = float(given.get("AI_MIN", -10.0)), float(given.get("AI_MAX", 10.0))
    per_volt = _per_volt(request, kind)
    scale = str(given.get("AI_CUSTOM_SCALE_NAME", "")) if given.get(MEASURES[kind][1]) == CUSTOM else ""
    scaled = scaling(system.saved.scales, scale) if scale else None
    bounded = kind in (*_SENSORS, "Voltage", "Accel4WireDCVoltage") and scaled is None and not module.simulated
    if bounded and max(abs(low), abs(high)) / abs(per_volt) > module.input_range_v * (1 + 1e-6):
        raise StatusError(status.INVALID_VALUE, f"Property: AI.Max\nRequested Value: {high}\nChannel: {physical}")
    return InputChannel(
        name, physical, module, per_volt=per_volt, scaled=scaled, low=low, high=high, kind=kind
    )  # fmt: skip


def _per_volt(request: Any, kind: str) -> float:
    if kind not in ("Accel", "ForceIEPE", "Accel4WireDCVoltage", "VelocityIEPE"):
        return 1.0
    known = fields_of(request)
    if "sensitivity" not in known:
        return 1.0
    volts = known["sensitivity"] * (1e-3 if known["sensitivity_units"] in MILLIVOLTS else 1.0)
    unit = STANDARD_GRAVITY if kind.startswith("Accel") and known["units"] == METRES else 1.0
    return unit / volts


def _choose_shunt(task: InputTask, name: str, module: Module) -> None:
    if task.get("AI_CURRENT_SHUNT_LOC", None, name) == LET_CHOOSE:
        task.attributes[name, "AI_CURRENT_SHUNT_LOC"] = INTERNAL if "CurrentRMS" in module.measures else EXTERNAL


def _scale_type(task: InputTask, name: str, call: str) -> None:
    known = {"Polynomial": 10449, "Table": 10450, "TwoPointLin": 15898}
    for ending, number in known.items():
        if call.endswith(ending):
            task.attributes[name, "AI_BRIDGE_SCALE_TYPE"] = number


def add_teds(system: SimulatedSystem, request: Any, call: str) -> Answer:
    """Channels whose sensors say themselves what they are.

    Raises:
        StatusError: no sensor with an electronic data sheet is there.
    """
    for physical in split_channel_list(str(request.physical_channel)):
        sheet = sheet_of(system, physical, call)
        if sheet is None:
            _require(system, physical, call)
            raise StatusError(status.NO_TEDS, f"Physical Channel: {physical}")
        task: InputTask = as_kind(system, request.task.name, InputTask)
        add_inputs(system, request, call)
        for channel in task.channels:
            if channel.physical == physical:
                task.attributes[channel.name, "AI_IS_TEDS"] = True
                for attribute, value in sheet.items():
                    task.attributes[channel.name, attribute] = value
    return {}
