"""Reads of every kind: wait until the samples are there, take them, and put them into the answer."""

import time
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as messages
from numpy.typing import NDArray

from modallab_simulators import faults
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import split_channel_list
from modallab_simulators.ni_daqmx_server.packing import FORMS, MessageForm
from modallab_simulators.ni_daqmx_server.status import StatusError

WAIT_S = 0.02
FOREVER_S = 1e9
_A_WARNING = 200015
_MESSAGES: Any = messages


def read(system: SimulatedSystem, call: str, asked: Any) -> Any:
    """The answer to a read.

    Raises:
        StatusError: nothing came in time of what cannot be had in parts, or it will never come.
    """
    form = FORMS[call]
    with system.lock:
        fault = system.faults.due(call)
        task = system.task(asked.task.name, AcquiringTask)
        begun = _begin(system, task) if fault is None or not fault.code else False
        wanted = 1 if form.scalar else asked.num_samps_per_chan
        count = wanted if wanted >= 0 else task.left(system.clock)
    if fault is not None and fault.code:
        raise StatusError(fault.code, samples=0)
    kind = fault.kind if fault is not None else ""
    values, short = _wait_and_take(system, asked, count, kind)
    with system.lock:
        values = _picked(task, values)
        if begun and (task.timing == "on-demand" or (task.finite and task.position >= task.finite)):
            system.stop(task)
        code = status.NOT_YET_AVAILABLE if short else (_A_WARNING if kind == faults.WARNING else 0)
        return _answer(form, call, asked, task, values, count, code)


def _answer(  # everything that an answer is made of
    form: MessageForm, call: str, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int, code: int
) -> Any:
    if form.scalar and not values.shape[1]:
        raise StatusError(code or status.NOT_YET_AVAILABLE, samples=0)
    room = getattr(asked, "array_size_in_samps", None)
    if room is not None and room < values.shape[0] * values.shape[1]:
        raise StatusError(status.BUFFER_TOO_SMALL, f"Task Name: {task.name}", samples=0)
    response = getattr(_MESSAGES, f"{call}Response")(status=code)
    return form.fill(response, asked, task, values, count)


def _begin(system: SimulatedSystem, task: AcquiringTask) -> bool:
    # A read starts a task that was not started.
    if task.running or not task.get("AUTO_START", True):
        return False
    system.start(task)
    return True


def _picked(task: AcquiringTask, values: NDArray[Any]) -> NDArray[Any]:
    wanted = task.get("CHANNELS_TO_READ")
    if not wanted:
        return values
    names = [c.name for c in task.all_channels()]
    return values[[names.index(name) for name in split_channel_list(wanted)]]


def _wait_and_take(system: SimulatedSystem, asked: Any, count: int, kind: str) -> tuple[NDArray[Any], bool]:
    deadline = time.monotonic() + (asked.timeout if asked.timeout >= 0 else FOREVER_S)
    given = {faults.TIME_OUT: 0, faults.PARTIAL: count // 2}.get(kind, count)
    while True:
        with system.lock:
            task = system.task(asked.task.name, AcquiringTask)
            system.require_unexpired(task)
            due_s = task.due_s(given, system.clock)
            if due_s <= 0 or time.monotonic() >= deadline:
                values = task.take(given, system.clock) if not task.waiting else task.take(0, system.clock)
                late = getattr(task, "trigger", None) is not None and not values.shape[1]
                if not late or time.monotonic() >= deadline:
                    return values, values.shape[1] < min(count, _most(task, values))
        time.sleep(max(0.0, min(due_s, WAIT_S, deadline - time.monotonic())))


def _most(task: AcquiringTask, values: NDArray[Any]) -> int:
    # What a finite acquisition still had: a read of more than that is not short.
    if not task.finite or task.timing == "on-demand":
        return 1 << 62
    triggered = getattr(task, "trigger", None) is not None
    return 1 << 62 if triggered else task.finite - task.position + values.shape[1]
