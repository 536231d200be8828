"""What each call does. A handler takes the system and the request, and returns the fields of the answer."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from modallab.core.units import STANDARD_GRAVITY
from modallab_simulators.ni_daqmx_server import attributes, status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.input_task import InputChannel, InputTask, ReferenceTrigger
from modallab_simulators.ni_daqmx_server.modules import Module, coerced
from modallab_simulators.ni_daqmx_server.output_task import LineTask, OutputTask, WatchdogTask
from modallab_simulators.ni_daqmx_server.status import StatusError, describe
from modallab_simulators.ni_daqmx_server.tasks import Task, require_terminal

Answer = dict[str, Any]
Handler = Callable[[SimulatedSystem, Any], Answer]

AUTO, NEW, ATTACH = 0, 1, 2
FINITE = 10178
MILLIVOLTS = (12509, 15891)
METRES = 12470
RISING = 10280


def create_task(system: SimulatedSystem, request: Any) -> Answer:
    """Make a task, or join the one of that name."""
    name = request.session_name or system.free_name()
    known = name in system.tasks
    if known and request.initialization_behavior == NEW:
        raise StatusError(status.DUPLICATE_TASK, f"Task Name: {name}")
    if not known and request.initialization_behavior == ATTACH:
        raise StatusError(status.INVALID_TASK, f"Task Name: {name}")
    if not known:
        system.add(Task(name))
    return {"task": name, "new_session_initialized": not known}


def clear_task(system: SimulatedSystem, request: Any) -> Answer:
    """Stop and forget."""
    system.clear(request.task.name)
    return {}


def start_task(system: SimulatedSystem, request: Any) -> Answer:
    """Start."""
    system.start(system.task(request.task.name, Task))
    return {}


def stop_task(system: SimulatedSystem, request: Any) -> Answer:
    """Stop."""
    system.stop(system.task(request.task.name, Task))
    return {}


def task_control(system: SimulatedSystem, request: Any) -> Answer:
    """Reserve, stop, abort and the like."""
    task = system.task(request.task.name, Task)
    if request.action_raw in (3, 4):
        system.reserved.take(task)
        task.committed = True
        if isinstance(task, InputTask) and request.action_raw == 3:
            task.supplies = system.supplies
            system.supplies.switch_on(task.fed, system.clock.now())
    elif request.action_raw == 0:
        system.start(task)
    elif request.action_raw in (1, 5, 6):
        task.committed = task.committed and request.action_raw == 1
        system.stop(task)
    return {}


def is_task_done(system: SimulatedSystem, request: Any) -> Answer:
    """Whether a task has come to its end."""
    task = system.task(request.task.name, Task)
    return {"is_task_done": task.done(system.clock) if isinstance(task, OutputTask) else not task.running}


def add_voltage(system: SimulatedSystem, request: Any) -> Answer:
    """Plain voltage inputs."""
    return _add_inputs(system, request, lambda module: True, 1.0)


def add_accelerometer(system: SimulatedSystem, request: Any) -> Answer:
    """IEPE accelerometers."""
    return _add_inputs(system, request, lambda module: module.iepe, _per_volt(request))


def add_force(system: SimulatedSystem, request: Any) -> Answer:
    """IEPE force transducers."""
    volts = request.sensitivity * (1e-3 if request.sensitivity_units_raw in MILLIVOLTS else 1.0)
    return _add_inputs(system, request, lambda module: module.iepe, 1 / volts)


def add_piezoresistive(system: SimulatedSystem, request: Any) -> Answer:
    """Accelerometers fed by a voltage, with four wires."""
    return _add_inputs(system, request, lambda module: module.bridge, _per_volt(request))


def add_teds(system: SimulatedSystem, request: Any) -> Answer:
    """IEPE accelerometers that say themselves how sensitive they are."""
    answer = _add_inputs(system, request, lambda module: module.iepe, 1.0)
    task = system.task(request.task.name, InputTask)
    channel = system.rig.channels[task.channels[-1].row]
    if channel.quantity != "acceleration" or channel.coupling != "IEPE" or not channel.serial:
        raise StatusError(status.NO_TEDS, f"Physical Channel: {request.physical_channel}")
    volts_per_g = channel.sensitivity("impact") * STANDARD_GRAVITY
    task.attributes[request.physical_channel, 0x692] = 1e3 * volts_per_g
    task.attributes[request.physical_channel, 0x219C] = 12509
    return answer


def add_teds_force(system: SimulatedSystem, request: Any) -> Answer:
    """IEPE force transducers that say themselves how sensitive they are."""
    answer = _add_inputs(system, request, lambda module: module.iepe, 1.0)
    task = system.task(request.task.name, InputTask)
    channel = system.rig.channels[task.channels[-1].row]
    if channel.quantity != "force" or channel.coupling != "IEPE" or not channel.serial:
        raise StatusError(status.NO_TEDS, f"Physical Channel: {request.physical_channel}")
    task.attributes[request.physical_channel, 0x2F81] = 1e3 * channel.sensitivity("impact")
    task.attributes[request.physical_channel, 0x2F82] = MILLIVOLTS[1]
    return answer


def _per_volt(request: Any) -> float:
    volts_per_g = request.sensitivity * (1e-3 if request.sensitivity_units_raw in MILLIVOLTS else 1.0)
    return (STANDARD_GRAVITY if request.units_raw == METRES else 1.0) / volts_per_g


def _add_inputs(system: SimulatedSystem, request: Any, fits: Callable[[Module], bool], per_volt: float) -> Answer:
    task = _as(system, request.task.name, InputTask)
    for physical in str(request.physical_channel).replace(" ", "").split(","):
        module = system.module_of(physical)
        if physical not in module.input_names():
            raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {physical}")
        if not fits(module):
            raise StatusError(status.WRONG_MEASUREMENT, f"Physical Channel: {physical}\nProduct: {module.product}")
        if max(abs(request.min_val), abs(request.max_val)) / abs(per_volt) > module.input_range_v * (1 + 1e-6):
            raise StatusError(
                status.INVALID_VALUE, f"Property: AI.Max\nRequested Value: {request.max_val}\nChannel: {physical}"
            )
        if any(physical == c.physical for c in task.channels):
            raise StatusError(-200489, f"Physical Channel: {physical}")
        fed = bool(getattr(request, "current_excit_val", 0.0))
        task.channels.append(InputChannel(physical, system.row_of(physical), module, per_volt, fed))
        task.resources.add(f"{module.name}/ai")
    return {}


def add_output(system: SimulatedSystem, request: Any) -> Answer:
    """An analog output."""
    task = _as(system, request.task.name, OutputTask)
    physical = request.physical_channel
    module = system.module_of(physical)
    if physical not in module.output_names():
        raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {physical}")
    if max(abs(request.min_val), abs(request.max_val)) > module.output_range_v * (1 + 1e-9):
        raise StatusError(status.INVALID_VALUE, f"Property: AO.Max\nRequested Value: {request.max_val}")
    task.physical, task.line, task.product = physical, system.lines[physical], module.product
    task.resources.add(physical)
    return {}


def add_lines(system: SimulatedSystem, request: Any) -> Answer:
    """Digital lines."""
    task = _as(system, request.task.name, LineTask)
    names = tuple(str(request.lines).replace(" ", "").split(","))
    for name in names:
        if name not in system.module_of(name).line_names():
            raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {name}")
    task.lines = names
    task.resources |= set(names)
    return {}


def set_clock(system: SimulatedSystem, request: Any) -> Answer:
    """Rate and length."""
    require_terminal(request.source)
    task = system.task(request.task.name, Task)
    finite = request.sample_mode_raw == FINITE
    if isinstance(task, InputTask):
        task.set_clock(request.rate, int(request.samps_per_chan) if finite else 0, 0)
    elif isinstance(task, OutputTask):
        module = system.module_of(task.physical)
        task.rate_hz = coerced((module,), 1, request.rate)
        task.finite = finite
    return {}


def set_reference_trigger(system: SimulatedSystem, request: Any) -> Answer:
    """Keep what was before an edge on one of the channels."""
    task = system.task(request.task.name, InputTask)
    names = [c.physical for c in task.channels]
    if request.trigger_source not in names:
        raise StatusError(status.BAD_TRIGGER_SOURCE, f"Source: {request.trigger_source}")
    if not task.finite:
        raise StatusError(status.NOT_SUPPORTED_HERE, "Property: RefTrig.Type")
    task.trigger = ReferenceTrigger(
        names.index(request.trigger_source),
        request.trigger_level,
        request.trigger_slope_raw == RISING,
        request.pretrigger_samples,
    )
    return {}


def write_analog(system: SimulatedSystem, request: Any) -> Answer:
    """Values for an output."""
    task = system.task(request.task.name, OutputTask)
    system.require_unexpired(task)
    values = np.array(request.write_array, dtype=np.float64)
    limit = system.module_of(task.physical).output_range_v
    if np.abs(values).max(initial=0.0) > limit * (1 + 1e-9):
        raise StatusError(status.INVALID_VALUE, f"Property: AO.Write\nMaximum Value: {limit}")
    if task.rate_hz == 0 or request.auto_start:
        system.reserved.take(task)
    task.write(values, system.clock)
    if request.auto_start and not task.running:
        system.start(task)
    system.changed()
    return {"samps_per_chan_written": request.num_samps_per_chan}


def write_lines(system: SimulatedSystem, request: Any) -> Answer:
    """States for digital lines."""
    task = system.task(request.task.name, LineTask)
    system.reserved.take(task)
    task.write(bool(request.write_array[-1]), system.clock)
    return {"samps_per_chan_written": 1}


def create_watchdog(system: SimulatedSystem, request: Any) -> Answer:
    """A watchdog on a device that has one."""
    if not system.chassis:
        raise StatusError(status.NO_WATCHDOG, f"Device: {request.device_name}")
    if request.device_name not in (*system.modules, "cDAQ1"):
        raise StatusError(status.NO_SUCH_DEVICE, f"Device Specified: {request.device_name}")
    name = request.session_name or system.free_name()
    system.add(WatchdogTask(name, device=request.device_name, timeout_s=request.timeout))
    return {"task": name, "new_session_initialized": True}


def set_watchdog_states(system: SimulatedSystem, request: Any) -> Answer:
    """Where outputs go when the watchdog expires."""
    task = system.task(request.task.name, WatchdogTask)
    names = str(request.channel_names).replace(" ", "").split(",")
    for name in names:
        if name not in system.lines:
            raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {name}")
    task.states = dict(zip(names, request.expir_state_array, strict=True))
    return {}


def control_watchdog(system: SimulatedSystem, request: Any) -> Answer:
    """Reset the timer. A chassis whose watchdog has expired wants to be reset itself: to clear it is not enough."""
    task = system.task(request.task.name, WatchdogTask)
    if task.expired and request.action_raw != 1 and request.action != 1:
        raise StatusError(status.EXPIRED_NOT_RESET, f"Task Name: {task.name}")
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


def reset_device(system: SimulatedSystem, request: Any) -> Answer:
    """Abort everything on a device."""
    system.reset(request.device_name)
    return {}


def self_test(system: SimulatedSystem, request: Any) -> Answer:
    """A device that is there passes."""
    attributes.device(system, request.device_name, 0x631)
    return {}


def error_string(system: SimulatedSystem, request: Any) -> Answer:
    """The text of a code."""
    return {"error_string": describe(request.error_code)}


def _as(system: SimulatedSystem, name: str, kind: Any) -> Any:
    # A task has no kind before its first channel.
    task = system.task(name, Task)
    if type(task) is Task:
        task = system.add(kind(name))
    elif not isinstance(task, kind):
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Task Name: {name}")
    return task


HANDLERS: dict[str, Handler] = {
    "CreateTask": create_task,
    "ClearTask": clear_task,
    "StartTask": start_task,
    "StopTask": stop_task,
    "TaskControl": task_control,
    "IsTaskDone": is_task_done,
    "CreateAIVoltageChan": add_voltage,
    "CreateAIAccelChan": add_accelerometer,
    "CreateAIForceIEPEChan": add_force,
    "CreateAIAccel4WireDCVoltageChan": add_piezoresistive,
    "CreateTEDSAIAccelChan": add_teds,
    "CreateTEDSAIForceIEPEChan": add_teds_force,
    "CreateAOVoltageChan": add_output,
    "CreateDOChan": add_lines,
    "CfgSampClkTiming": set_clock,
    "CfgAnlgEdgeRefTrig": set_reference_trigger,
    "WriteAnalogF64": write_analog,
    "WriteDigitalLines": write_lines,
    "CreateWatchdogTimerTaskEx": create_watchdog,
    "CfgWatchdogAOExpirStates": set_watchdog_states,
    "ControlWatchdogTask": control_watchdog,
    "PerformBridgeShuntCalEx": shunt,
    "ResetDevice": reset_device,
    "SelfTestDevice": self_test,
    "GetErrorString": error_string,
}
