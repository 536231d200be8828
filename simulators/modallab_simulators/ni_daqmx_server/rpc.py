"""The wire: NI's gRPC service, all calls of one kind by one way."""

import logging
import re
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, NoReturn

import grpc
from nidaqmx._stubs import nidaqmx_pb2 as messages

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.answers.dispatch import CALL, attribute
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.sessions import wait_until_done
from modallab_simulators.ni_daqmx_server.calls.table import HANDLERS
from modallab_simulators.ni_daqmx_server.events import STREAMS
from modallab_simulators.ni_daqmx_server.local_mode import LocalClients
from modallab_simulators.ni_daqmx_server.packing import FORMS
from modallab_simulators.ni_daqmx_server.reads import read
from modallab_simulators.ni_daqmx_server.status import SessionError, StatusError

SERVICE = "/nidaqmx_grpc.NiDAQmx/"
MESSAGE_BYTES = 256 << 20
WORKERS = 48

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
