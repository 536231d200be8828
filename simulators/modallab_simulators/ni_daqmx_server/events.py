"""Events that clients register for: every so many samples, at the end of a task, at a signal."""

import time
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any

import grpc
from nidaqmx._stubs import nidaqmx_pb2 as messages

from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Task
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.sessions import is_done
from modallab_simulators.ni_daqmx_server.counter_task import CounterOutputTask, LineTask
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.status import StatusError

_MESSAGES: Any = messages
_NUMBERS = count(1)
LOOK_S = 0.001
ACQUIRED, TRANSFERRED = 1, 2
WRONG_EVENT = {ACQUIRED: -200981, TRANSFERRED: -200980}
REGISTERED = {"every 1": -200966, "every 2": -200967, "done": -200950, "signal": -200949}


def every_n_samples(system: SimulatedSystem, asked: Any, context: grpc.ServicerContext) -> Iterator[Any]:
    """One answer for every so many samples."""
    kind = asked.every_n_samples_event_type_raw or asked.every_n_samples_event_type
    with system.lock:
        task = system.task(asked.task.name, Task)
        if (kind == ACQUIRED) is not isinstance(task, AcquiringTask):
            raise StatusError(WRONG_EVENT[kind], f"Task Name: {task.name}")
    yield from _watched(
        system, asked, context, f"every {kind}", lambda found: _moved(system, found) // asked.n_samples,
        lambda: _MESSAGES.RegisterEveryNSamplesEventResponse(
            every_n_samples_event_type_raw=kind, n_samples=asked.n_samples
        ),
    )  # fmt: skip


def done(system: SimulatedSystem, asked: Any, context: grpc.ServicerContext) -> Iterator[Any]:
    """One answer for each run of a task, when it has come to its end."""
    yield from _watched(
        system, asked, context, "done", lambda found: int(_ends(system, found)),
        lambda: _MESSAGES.RegisterDoneEventResponse(status=0),
    )  # fmt: skip


def signal(system: SimulatedSystem, asked: Any, context: grpc.ServicerContext) -> Iterator[Any]:
    """One answer for each sample."""
    number = asked.signal_id_raw or asked.signal_id
    yield from _watched(
        system, asked, context, "signal", lambda found: _moved(system, found),
        lambda: _MESSAGES.RegisterSignalEventResponse(signal_id=number),
    )  # fmt: skip


def _ends(system: SimulatedSystem, task: Task) -> bool:
    # The task that is read on demand has no end of its own.
    return task.running and task.timing != "on-demand" and is_done(system, task)


def _moved(system: SimulatedSystem, task: Task) -> int:
    if isinstance(task, AcquiringTask):
        return task.acquired(system.clock)
    if isinstance(task, OutputTask) and task.finite and task.channels[0].module.simulated:
        return task.samples
    if isinstance(task, OutputTask):
        return task.played(system.clock)
    if isinstance(task, LineTask) and not task.waiting:
        return max(0, int((system.clock.now() - task.start_s) * task.rate_hz))
    return int(isinstance(task, CounterOutputTask) and task.done(system.clock))


def _watched(  # an event is all of this
    system: SimulatedSystem,
    asked: Any,
    context: grpc.ServicerContext,
    key: str,
    counted: Callable[[Task], int],
    answer: Callable[[], Any],
) -> Iterator[Any]:
    with system.lock:
        task = system.task(asked.task.name, Task)
        if task.events.get(key):
            raise StatusError(REGISTERED[key], f"Task Name: {task.name}")
        number = next(_NUMBERS)
        task.events[key] = number
        events = task.events
    # Without initial metadata the client would wait for ever for its registration.
    context.send_initial_metadata(())
    reported, run = 0, 0
    try:
        while context.is_active():
            with system.lock:
                found = system.tasks.get(asked.task.name)
                if found is None or events.get(key) != number:
                    return
                if found.runs != run:
                    reported, run = 0, found.runs
                passed = counted(found) if found.running else reported
            if passed > reported:
                reported += 1
                yield answer()
            else:
                time.sleep(LOOK_S)
    finally:
        if events.get(key) == number:
            events.pop(key)


def unregister(system: SimulatedSystem, asked: Any, key: str) -> dict[str, Any]:
    """Nobody wants these events any more."""
    task = system.task(asked.task.name, Task)
    for name in [name for name in task.events if name.startswith(key)]:
        task.events.pop(name)
    return {}


STREAMS: dict[str, Callable[[SimulatedSystem, Any, grpc.ServicerContext], Iterator[Any]]] = {
    "RegisterEveryNSamplesEvent": every_n_samples,
    "RegisterDoneEvent": done,
    "RegisterSignalEvent": signal,
}
