"""A generator behind HiSLIP, as instruments in a network offer it beside a bare socket.

Two connections belong to one client: messages on the first, what must not wait behind them on the second. Every
message has a number, and an answer bears that of its question. Source: IVI-6.1, High-Speed LAN Instrument Protocol.
"""

import socket
import struct
import threading
from contextlib import suppress
from dataclasses import dataclass

from modallab_simulators.scpi_generator.device import ScpiGenerator
from modallab_simulators.scpi_generator.ports import Port

HEADER = struct.Struct("!2sBBIQ")
INITIALIZE, INITIALIZED, FATAL = 0, 1, 2
LOCK, LOCKED, DATA, DATA_END = 4, 5, 6, 7
CLEARED, CLEARED_SYNC = 8, 9
MAX_SIZE, MAX_SIZE_IS = 15, 16
INITIALIZE_ASYNC, INITIALIZED_ASYNC = 17, 18
CLEAR, STATUS, STATUS_IS, CLEARED_ASYNC = 19, 21, 22, 23
VERSION = 0x0100
MOST_BYTES = 1 << 20


@dataclass(frozen=True, slots=True)
class Message:
    """One message with its header's fields."""

    kind: int
    control: int
    parameter: int
    payload: bytes


class HislipGenerator(Port):
    """A generator in the network that speaks HiSLIP, to one client after another."""

    def __init__(self, device: ScpiGenerator) -> None:
        super().__init__(device)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = f"TCPIP0::127.0.0.1::hislip0,{self._listener.getsockname()[1]}::INSTR"
        self._connections: list[socket.socket] = []
        self._obeying = threading.Lock()
        threading.Thread(target=self._accept, name="hislip", daemon=True).start()

    def close(self) -> None:
        """Leave the network."""
        for each in (self._listener, *self._connections):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                connection = self._listener.accept()[0]
                self._connections.append(connection)
                threading.Thread(target=self._serve, args=(connection,), name="hislip", daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        # Whoever asked has hung up, or the plug was pulled.
        with suppress(OSError, EOFError):
            while True:
                self._answer(connection, _received(connection))

    def _answer(self, connection: socket.socket, message: Message) -> None:
        if message.kind in (DATA, DATA_END):
            with self._obeying:
                self._link.take(
                    message.payload, lambda data: _send(connection, DATA_END, parameter=message.parameter, payload=data)
                )
        elif message.kind == INITIALIZE:
            # The high half is the version, the low half the session.
            _send(connection, INITIALIZED, parameter=VERSION << 16 | 1)
        elif message.kind == INITIALIZE_ASYNC:
            _send(connection, INITIALIZED_ASYNC)
        elif message.kind == MAX_SIZE:
            _send(connection, MAX_SIZE_IS, payload=struct.pack("!Q", MOST_BYTES))
        elif message.kind in (CLEAR, CLEARED, STATUS, LOCK):
            said = {CLEAR: CLEARED_ASYNC, CLEARED: CLEARED_SYNC, STATUS: STATUS_IS, LOCK: LOCKED}[message.kind]
            _send(connection, said, control=int(message.kind == LOCK))
        else:
            _send(connection, FATAL, payload=f"unrecognized message type {message.kind}".encode())


def _send(connection: socket.socket, kind: int, control: int = 0, parameter: int = 0, payload: bytes = b"") -> None:
    connection.sendall(HEADER.pack(b"HS", kind, control, parameter, len(payload)) + payload)


def _received(connection: socket.socket) -> Message:
    _, kind, control, parameter, length = HEADER.unpack(_exactly(connection, HEADER.size))
    return Message(kind, control, parameter, _exactly(connection, length))


def _exactly(connection: socket.socket, count: int) -> bytes:
    found = b""
    while len(found) < count:
        more = connection.recv(count - len(found))
        if not more:
            raise EOFError
        found += more
    return found
