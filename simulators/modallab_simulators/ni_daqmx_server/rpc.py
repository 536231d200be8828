"""The wire: NI's gRPC service, all calls of one kind by one way."""

import re
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import grpc
import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as messages

from modallab_simulators import faults
from modallab_simulators.ni_daqmx_server import attributes, status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.handlers import HANDLERS
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.lines import Floats
from modallab_simulators.ni_daqmx_server.local_mode import LocalClients
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Task

SERVICE = "/nidaqmx_grpc.NiDAQmx/"
MESSAGE_BYTES = 256 << 20
WORKERS = 12
WAIT_S = 0.02

_ATTRIBUTE = re.compile(
    r"(Get|Set|Reset)(SystemInfo|Task|Chan|Read|Write|TimingEx|Timing|Buffer|Device|PhysicalChan|Watchdog|Trig)"
    r"Attribute(\w*)"
)

# The generated classes are made when the module is loaded, so no checker can see them.
_MESSAGES: Any = messages


def serve(
    system: SimulatedSystem, port: int, credentials: grpc.ServerCredentials | None = None, *, local: bool = False
) -> tuple[Any, int]:
    """Begin to listen on the loopback; returns the server and its port. `local`: see `local_mode`."""
    clients = LocalClients(system) if local else None
    server = grpc.server(
        ThreadPoolExecutor(WORKERS),
        handlers=[_Calls(system, clients)],
        options=[("grpc.max_send_message_length", MESSAGE_BYTES), ("grpc.max_receive_message_length", MESSAGE_BYTES)],
    )
    address = f"127.0.0.1:{0 if clients else port}"
    bound = server.add_insecure_port(address) if credentials is None else server.add_secure_port(address, credentials)
    server.start()
    threading.Thread(target=system.watch, name="watchdogs", daemon=True).start()
    return server, clients.listen(port, bound) if clients else bound


class _Calls(grpc.GenericRpcHandler):
    """Finds what answers a call by its name."""

    def __init__(self, system: SimulatedSystem, clients: LocalClients | None) -> None:
        self._system = system
        self._clients = clients

    def service(self, handler_call_details: grpc.HandlerCallDetails) -> Any:
        method = str(handler_call_details.method)
        name = method.removeprefix(SERVICE)
        request = getattr(_MESSAGES, f"{name}Request", None)
        if not method.startswith(SERVICE) or request is None:
            return None
        if name == "RegisterEveryNSamplesEvent":
            stream = partial(_every_n_samples, self._system)
            return grpc.unary_stream_rpc_method_handler(stream, request.FromString, _encode)
        answer = _answerer(self._system, name)
        if answer is None:
            return None

        def call(asked: Any, context: grpc.ServicerContext) -> Any:
            try:
                return answer(asked if self._clients is None else self._clients.scoped(asked, context.peer()))
            except StatusError as error:
                _reject(context, error)

        return grpc.unary_unary_rpc_method_handler(call, request.FromString, _encode)


def _answerer(system: SimulatedSystem, name: str) -> Callable[[Any], Any] | None:
    if name == "ReadAnalogF64":
        return lambda asked: _read(system, asked)
    if name == "WaitUntilTaskDone":
        return lambda asked: _wait_until_done(system, asked)
    if name in HANDLERS:
        return lambda asked: _handle(system, name, asked)
    match = _ATTRIBUTE.fullmatch(name)
    return None if match is None else (lambda asked: _attribute(system, name, match, asked))


def _wait_until_done(system: SimulatedSystem, asked: Any) -> Any:
    deadline = time.monotonic() + (asked.time_to_wait if asked.time_to_wait >= 0 else 1e9)
    while True:
        with system.lock:
            task = system.task(asked.task.name, Task)
            if isinstance(task, OutputTask) and task.wave is not None and task.finite and not system.clock.pace:
                # Whoever waits lets time pass.
                system.clock.read_up_to(task.wave.end_s)
            done = task.done(system.clock) if isinstance(task, OutputTask) else not task.running
        if done:
            return _MESSAGES.WaitUntilTaskDoneResponse()
        if time.monotonic() >= deadline:
            raise StatusError(status.NOT_FINISHED, f"Task Name: {asked.task.name}")
        time.sleep(WAIT_S / 10)


def _handle(system: SimulatedSystem, name: str, asked: Any) -> Any:
    with system.lock:
        _spoil(system, name)
        fields = HANDLERS[name](system, asked)
    response = getattr(_MESSAGES, f"{name}Response")()
    for key, value in fields.items():
        if key == "task":
            response.task.name = value
        else:
            setattr(response, key, value)
    return response


def _attribute(system: SimulatedSystem, name: str, match: "re.Match[str]", asked: Any) -> Any:
    verb, group, kind = match.groups()
    number = asked.attribute_raw or asked.attribute
    with system.lock:
        _spoil(system, name)
        if verb == "Get":
            return _attribute_answer(name, kind, _get(system, group, asked, number))
        if verb == "Set":
            value = asked.value_raw if kind == "Int32" else asked.value
            attributes.put(system, asked.task.name, getattr(asked, "channel", ""), number, value)
    return getattr(_MESSAGES, f"{name}Response")()


def _attribute_answer(name: str, kind: str, value: Any) -> Any:
    response = getattr(_MESSAGES, f"{name}Response")()
    if kind.endswith("Array"):
        response.value.extend(value)
    elif kind == "Int32":
        response.value_raw = value
    else:
        response.value = value
    return response


def _get(system: SimulatedSystem, group: str, asked: Any, number: int) -> Any:
    if group == "SystemInfo":
        return attributes.system(system, number)
    if group == "Device":
        return attributes.device(system, asked.device_name, number)
    if group == "PhysicalChan":
        return attributes.physical_channel(system, asked.physical_channel, number)
    if group == "Chan":
        return attributes.channel(system, asked.task.name, asked.channel, number)
    by_task = {
        "Task": attributes.task,
        "Read": attributes.read,
        "Write": attributes.write,
        "Timing": attributes.timing,
        "TimingEx": attributes.timing,
        "Watchdog": attributes.watchdog,
    }
    if group not in by_task:
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Property: {number:#x}")
    return by_task[group](system, asked.task.name, number)


def _spoil(system: SimulatedSystem, name: str) -> None:
    fault = system.faults.due(name)
    if fault is not None and fault.code:
        raise StatusError(fault.code, samples=0 if name.startswith("Read") else None)


def _read(system: SimulatedSystem, asked: Any) -> bytes:
    with system.lock:
        fault = system.faults.due("ReadAnalogF64")
        task = system.task(asked.task.name, InputTask)
        system.require_unexpired(task)
        count = asked.num_samps_per_chan if asked.num_samps_per_chan >= 0 else _there(system, task)
    if fault is not None and fault.code:
        raise StatusError(fault.code, samples=0)
    kind = fault.kind if fault is not None else ""
    values, code = _wait_and_take(system, asked, count, kind)
    return _encode_read(
        values, count, status.NOT_YET_AVAILABLE if code else (_A_WARNING if kind == faults.WARNING else 0)
    )


_A_WARNING = 200015


def _there(system: SimulatedSystem, task: InputTask) -> int:
    return task.acquired(system.clock) - task.position


def _wait_and_take(system: SimulatedSystem, asked: Any, count: int, kind: str) -> tuple[Floats, bool]:
    deadline = time.monotonic() + (asked.timeout if asked.timeout >= 0 else 1e9)
    given = {faults.TIME_OUT: 0, faults.PARTIAL: count // 2}.get(kind, count)
    while True:
        with system.lock:
            task = system.task(asked.task.name, InputTask)
            due_s = task.due_s(given, system.clock)
            if due_s <= 0 or time.monotonic() >= deadline:
                values = task.take(given, system.clock)
                late = task.trigger is not None and not values.shape[1] and time.monotonic() < deadline
                if not late:
                    return values, values.shape[1] < count
        time.sleep(max(0.0, min(due_s, WAIT_S, deadline - time.monotonic())))


def _encode_read(values: Floats, count: int, code: int) -> bytes:
    """The answer to a read, packed by hand: as the generated classes would, at a fraction of their time."""
    channels, there = values.shape
    array = np.zeros((channels, count))
    array[:, :there] = values
    head = _MESSAGES.ReadAnalogF64Response(status=code, samps_per_chan_read=there).SerializeToString()
    body = array.astype("<f8", copy=False).tobytes()
    return head + b"\x12" + _varint(len(body)) + body


def _varint(value: int) -> bytes:
    found = bytearray()
    while value > 0x7F:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    found.append(value)
    return bytes(found)


def _every_n_samples(system: SimulatedSystem, asked: Any, context: grpc.ServicerContext) -> Iterator[Any]:
    # Without initial metadata the client would wait for ever for its registration.
    context.send_initial_metadata(())
    reported = 0
    while context.is_active():
        with system.lock:
            task = system.tasks.get(asked.task.name)
            if task is None:
                return
            acquired = task.acquired(system.clock) if isinstance(task, InputTask) and task.running else 0
        if acquired >= reported + asked.n_samples:
            reported += asked.n_samples
            yield _MESSAGES.RegisterEveryNSamplesEventResponse(
                every_n_samples_event_type_raw=asked.every_n_samples_event_type_raw, n_samples=asked.n_samples
            )
        else:
            time.sleep(0.001)


def _reject(context: grpc.ServicerContext, error: StatusError) -> None:
    metadata = [("ni-error", str(error.code))]
    if error.samples is not None:
        metadata.append(("ni-samps-per-chan-read", str(error.samples)))
    context.set_trailing_metadata(tuple(metadata))
    context.abort(grpc.StatusCode.UNKNOWN, error.text)


def _encode(response: Any) -> bytes:
    return response if isinstance(response, bytes) else response.SerializeToString()
