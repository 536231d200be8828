"""The wire: NI's gRPC service, all calls of one kind by one way."""

import logging
import os
import re
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import Any, NoReturn

import grpc
import psutil
from nidaqmx._stubs import nidaqmx_pb2 as messages

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.answers.tasks import CALL, attribute
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.sessions import wait_until_done
from modallab_simulators.ni_daqmx_server.calls.table import HANDLERS
from modallab_simulators.ni_daqmx_server.events import STREAMS
from modallab_simulators.ni_daqmx_server.output_task import OutputTask, WatchdogTask
from modallab_simulators.ni_daqmx_server.packing import FORMS
from modallab_simulators.ni_daqmx_server.reads import read
from modallab_simulators.ni_daqmx_server.status import SessionError, StatusError

LOOK_S = 0.005
PIECE_BYTES = 1 << 18


class LocalClients:
    """Which process asks over which connection, and what becomes of what it started."""

    def __init__(self, system: SimulatedSystem) -> None:
        self._system = system
        self._process_of: dict[int, int] = {}
        self._known = threading.Lock()
        self._inner_port = 0

    def listen(self, port: int, inner_port: int) -> int:
        """Relay what comes to `port` (0: any) of the loopback to the server at `inner_port`; returns the port."""
        self._inner_port = inner_port
        listener = socket.create_server(("127.0.0.1", port))
        threading.Thread(target=self._accept, args=(listener,), name="relay", daemon=True).start()
        threading.Thread(target=self._watch, name="clients", daemon=True).start()
        return int(listener.getsockname()[1])

    def scoped(self, asked: Any, peer: str) -> Any:
        """A request as this client means it: its tasks' names are its own."""
        with self._known:
            client = f"{self._process_of.get(int(peer.rpartition(':')[2]), 0)}|"
        fields = asked.DESCRIPTOR.fields_by_name
        if "session_name" in fields:
            asked.session_name = client + (asked.session_name or self._system.free_name())
        elif "task" in fields and not asked.task.name.startswith(client):
            asked.task.name = client + asked.task.name
        return asked

    def _accept(self, listener: socket.socket) -> None:
        while True:
            outer, address = listener.accept()
            inner = socket.create_connection(("127.0.0.1", self._inner_port))
            for end in (outer, inner):
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            # Noted before the first byte goes on, so that no request comes from nobody.
            place = int(inner.getsockname()[1])
            process = _process_at(int(address[1]))
            with self._known:
                self._process_of[place] = process
            threading.Thread(target=self._pump, args=(outer, inner, place), daemon=True).start()
            threading.Thread(target=_copy, args=(inner, outer), daemon=True).start()

    def _pump(self, outer: socket.socket, inner: socket.socket, place: int) -> None:
        _copy(outer, inner)
        with self._known:
            process = self._process_of.pop(place, 0)
            gone = process not in self._process_of.values()
        if gone:
            self._died(process)

    def _died(self, process: int) -> None:
        with self._system.lock:
            for task in self._tasks_of(process):
                # What a watchdog watches over is just that: that nobody resets it any more.
                if not isinstance(task, WatchdogTask):
                    self._system.clear(task.name)

    def _watch(self) -> None:
        while True:
            time.sleep(LOOK_S)
            with self._known:
                processes = set(self._process_of.values())
            for process in processes:
                if _frozen(process):
                    self._starve(process)

    def _starve(self, process: int) -> None:
        with self._system.lock:
            for task in self._tasks_of(process):
                if isinstance(task, OutputTask) and not task.starved:
                    task.starve(self._system.clock)
                    self._system.changed()

    def _tasks_of(self, process: int) -> list[Any]:
        return [task for name, task in self._system.tasks.items() if name.startswith(f"{process}|")]


def _copy(source: socket.socket, sink: socket.socket) -> None:
    with suppress(OSError):
        while piece := source.recv(PIECE_BYTES):
            sink.sendall(piece)
    for end in (source, sink):
        with suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)


def _process_at(port: int) -> int:
    """The process of this machine whose end of a connection is at a port; where it can't be known, one for itself."""
    for connection in psutil.net_connections("tcp"):
        local = connection.laddr
        if local and local.port == port and connection.pid not in (None, os.getpid()):
            return int(connection.pid or 0)
    return -port


def _frozen(process: int) -> bool:
    try:
        return process > 0 and psutil.Process(process).status() == psutil.STATUS_STOPPED
    except psutil.Error:
        return False


SERVICE = "/nidaqmx_grpc.NiDAQmx/"
MESSAGE_BYTES = 256 << 20
WORKERS = 48

# The generated classes are made when the module is loaded, so no checker can see them.
_MESSAGES: Any = messages


def serve(
    system: SimulatedSystem, port: int, credentials: grpc.ServerCredentials | None = None, *, local: bool = False
) -> tuple[Any, int]:
    """Begin to listen on the loopback; returns the server and its port. `local`: see `LocalClients`."""
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
        if name in STREAMS:
            return grpc.unary_stream_rpc_method_handler(_streamed(self._system, name), request.FromString, _encode)  # pyrefly: ignore[bad-argument-type]
        answer = _answerer(self._system, name)

        def call(asked: Any, context: grpc.ServicerContext) -> Any:
            try:
                return answer(asked if self._clients is None else self._clients.scoped(asked, context.peer()))
            except SessionError as error:
                found = grpc.StatusCode.ALREADY_EXISTS if error.exists else grpc.StatusCode.FAILED_PRECONDITION
                context.abort(found, error.text)
            except Exception as error:
                _reject(context, _as_status(name, error))

        return grpc.unary_unary_rpc_method_handler(call, request.FromString, _encode)  # pyrefly: ignore[bad-argument-type]


def _answerer(system: SimulatedSystem, name: str) -> Callable[[Any], Any]:
    if name in FORMS:
        return lambda asked: read(system, name, asked)
    if name == "WaitUntilTaskDone":
        return lambda asked: _filled(name, wait_until_done(system, asked))
    if name in HANDLERS:
        return lambda asked: _handle(system, name, asked)
    match = CALL.fullmatch(name)
    return partial(_reject_unknown, name) if match is None else partial(_attribute, system, name, match)


def _reject_unknown(name: str, _: Any) -> NoReturn:
    raise StatusError(status.NOT_SIMULATED, f"Function: {name}")


def _handle(system: SimulatedSystem, name: str, asked: Any) -> Any:
    with system.lock:
        _spoil(system, name)
        return _filled(name, HANDLERS[name](system, asked))


def _filled(name: str, fields: dict[str, Any]) -> Any:
    response = getattr(_MESSAGES, f"{name}Response")()
    for key, value in fields.items():
        if key == "task":
            response.task.name = value
        elif isinstance(value, list):
            getattr(response, key).extend(value)
        elif hasattr(value, "DESCRIPTOR"):
            getattr(response, key).CopyFrom(value)
        else:
            setattr(response, key, value)
    return response


def _attribute(system: SimulatedSystem, name: str, match: "re.Match[str]", asked: Any) -> Any:
    with system.lock:
        _spoil(system, name)
        return attribute(system, name, match, asked)


def _spoil(system: SimulatedSystem, name: str) -> None:
    fault = system.faults.due(name)
    if fault is not None and fault.code:
        raise StatusError(fault.code, samples=0 if name.startswith("Read") else None)


def _streamed(system: SimulatedSystem, name: str) -> Callable[[Any, grpc.ServicerContext], Iterator[Any]]:
    def stream(asked: Any, context: grpc.ServicerContext) -> Iterator[Any]:
        try:
            yield from STREAMS[name](system, asked, context)
        except Exception as error:
            _reject(context, _as_status(name, error))

    return stream


def _as_status(name: str, error: Exception) -> StatusError:
    # A client of the driver knows no other failure than a status.
    if isinstance(error, StatusError):
        return error
    logging.getLogger(__name__).error("%s failed", name, exc_info=error)
    said = f"Function: {name}\n{type(error).__name__}: {error}"
    return StatusError(status.SOFTWARE_FAULT, said, samples=0 if name.startswith("Read") else None)


def _reject(context: grpc.ServicerContext, error: StatusError) -> None:
    metadata = [("ni-error", str(error.code))]
    if error.samples is not None:
        metadata.append(("ni-samps-per-chan-read", str(error.samples)))
    context.set_trailing_metadata(tuple(metadata))
    context.abort(grpc.StatusCode.UNKNOWN, error.text)


def _encode(response: Any) -> bytes:
    return response if isinstance(response, bytes) else response.SerializeToString()
