"""Tasks as sessions: made, attached to, started, waited for, cleared."""

import time
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as messages

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Task
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.analog_inputs import add_inputs
from modallab_simulators.ni_daqmx_server.calls.channels import add_analog
from modallab_simulators.ni_daqmx_server.calls.kinds import split_channel_list
from modallab_simulators.ni_daqmx_server.calls.timing import use_saved_timing, verify
from modallab_simulators.ni_daqmx_server.counter_task import CounterOutputTask, LineTask
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.status import SessionError, StatusError

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


Answer = dict[str, Any]

NEW, ATTACH = 1, 2
VERIFY, COMMIT, RESERVE, UNRESERVE, ABORT = 2, 3, 4, 5, 6
LOOK_S = 0.005
STOPPED_EARLY = 200010


def session(system: SimulatedSystem, request: Any) -> tuple[str, bool]:
    """Name of the session that a request makes or attaches to, and whether it is new.

    Raises:
        SessionError: there is one and there must not be, or the other way round.
    """
    name = request.session_name or system.free_name()
    known = name in system.tasks
    if known and request.initialization_behavior == NEW:
        raise SessionError(f'Cannot initialize "{name}" when a session already exists.', exists=True)
    if not known and request.initialization_behavior == ATTACH:
        raise SessionError(f'Cannot attach to "{name}" because a session has not been initialized.', exists=False)
    return name, not known


def create_task(system: SimulatedSystem, request: Any) -> Answer:
    """Make a task, or join the one of that name."""
    name, new = session(system, request)
    if new:
        system.add(Task(name))
    return {"task": name, "new_session_initialized": new}


def load_task(system: SimulatedSystem, request: Any) -> Answer:
    """Make a task as it was saved."""
    name = request.session_name
    if name not in system.saved.tasks:
        raise StatusError(status.NO_SUCH_TASK, f"Task Name: {name}")
    found, new = session(system, request)
    if new:
        system.add(Task(found))
        add_saved(system, found, split_channel_list(system.saved.tasks[name]["Channels"]))
        use_saved_timing(system.task(found, Task), system.saved.tasks[name])
    return {"task": found, "new_session_initialized": new}


def add_global(system: SimulatedSystem, request: Any) -> Answer:
    """Add saved channels to a task."""
    add_saved(system, request.task.name, split_channel_list(request.channel_names))
    return {}


def clear_task(system: SimulatedSystem, request: Any) -> Answer:
    """Stop and forget."""
    system.clear(request.task.name)
    return {}


def start_task(system: SimulatedSystem, request: Any) -> Answer:
    """Start."""
    task = with_channels(system.task(request.task.name, Task))
    verify(system, task)
    system.start(task)
    return {}


def with_channels(task: Task) -> Task:
    """The task, if it can be started.

    Raises:
        StatusError: it has no channels.
    """
    if type(task) is Task:
        raise StatusError(status.NO_CHANNELS, f"Task Name: {task.name}")
    return task


def stop_task(system: SimulatedSystem, request: Any) -> Answer:
    """Stop; a finite generation that had not ended is reported by a warning."""
    task = system.task(request.task.name, Task)
    early = _stops_early(system, task)
    system.stop(task)
    return {"status": STOPPED_EARLY} if early else {}


def _stops_early(system: SimulatedSystem, task: Task) -> bool:
    if not task.running or not isinstance(task, OutputTask) or not task.finite:
        return False
    return not is_done(system, task)


def task_control(system: SimulatedSystem, request: Any) -> Answer:
    """Reserve, stop, abort and the like."""
    task = system.task(request.task.name, Task)
    action = request.action_raw or request.action
    if action in (VERIFY, COMMIT, RESERVE):
        verify(system, with_channels(task))
    if action in (COMMIT, RESERVE):
        system.require_unexpired(task)
        system.reserved.take(with_channels(task))
        task.kept = True
    elif action == 0:
        system.start(with_channels(task))
    elif action in (1, UNRESERVE, ABORT):
        task.kept = task.kept and action == 1
        system.stop(task)
    return {}


def is_done(system: SimulatedSystem, task: Task) -> bool:
    """Whether a task has come to its end."""
    if isinstance(task, OutputTask | AcquiringTask | LineTask | CounterOutputTask):
        return task.done(system.clock)
    return not task.running


def is_task_done(system: SimulatedSystem, request: Any) -> Answer:
    """Whether a task has come to its end."""
    return {"is_task_done": is_done(system, system.task(request.task.name, Task))}


def wait_until_done(system: SimulatedSystem, request: Any) -> Answer:
    """Wait for the end of a task; without the system's lock, which others need meanwhile.

    Raises:
        StatusError: it did not end in time.
    """
    deadline = time.monotonic() + request.time_to_wait if request.time_to_wait >= 0 else float("inf")
    while True:
        with system.lock:
            task = system.task(request.task.name, Task)
            if isinstance(task, OutputTask) and task.finite and task.wave is not None and not system.clock.pace:
                # Whoever waits lets time pass.
                system.clock.read_up_to(task.wave.end_s)
            if is_done(system, task):
                return {}
        if time.monotonic() >= deadline:
            raise StatusError(status.NOT_FINISHED, f"Task Name: {request.task.name}")
        time.sleep(LOOK_S)


def channel_by_number(system: SimulatedSystem, request: Any) -> Answer:
    """One channel of a task, counted from 1."""
    channels = system.task(request.task.name, Task).all_channels()
    if not 1 <= request.index <= len(channels):
        raise StatusError(status.INVALID_VALUE, f"Index: {request.index}")
    return {"buffer": channels[request.index - 1].name}


def devices_of(task: Task) -> list[str]:
    """Devices of a task: the chassis counts as one where a module is in it."""
    found = [name for c in task.all_channels() for name in ((c.module.chassis or "") or c.module.name, c.module.name)]
    return list(dict.fromkeys(found))


def device_by_number(system: SimulatedSystem, request: Any) -> Answer:
    """One device of a task, counted from 1."""
    found = devices_of(system.task(request.task.name, Task))
    if not 1 <= request.index <= len(found):
        raise StatusError(status.INVALID_VALUE, f"Index: {request.index}")
    return {"buffer": found[request.index - 1]}
