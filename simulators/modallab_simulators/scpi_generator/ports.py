"""Where a generator can be reached, and the bytes to and from it, with all that goes wrong there.

Two connections belong to one client: messages on the first, what must not wait behind them on the second. Every
message has a number, and an answer bears that of its question. Source: IVI-6.1, High-Speed LAN Instrument Protocol.
"""

import os
import select
import socket
import struct
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from modallab_simulators import faults
from modallab_simulators.scpi_generator.device import ScpiGenerator

Write = Callable[[bytes], object]


class CommandLink:
    """Cuts what comes into lines, lets the instrument obey, and sends what it answers."""

    def __init__(self, device: ScpiGenerator) -> None:
        self._device = device
        self._pending = b""
        self._fault, self._slow_s, self._late_s = "", 0.0, 0.0

    def arm_fault(self, line: str) -> None:
        """Arm a fault, such as `clipped-set-point 0.1`, `front-panel amplitude 5`, `late-answer 1.5`.

        Raises:
            ValueError: a generator cannot have it.
        """
        kind, words = faults.parse_fault(line, faults.GENERATOR_FAULTS)
        if kind == faults.CLIPPED:
            self._device.clip_vpp = float(words[0])
        elif kind == faults.COERCED:
            self._device.gain = float(words[0])
        elif kind == faults.FRONT_PANEL:
            self._device.panel(words[0], words[1])
        elif kind == faults.POWER_CYCLE:
            self._device.power_cycle()
        elif kind == faults.STAYS_ON:
            self._device.deaf = words[0] if words else "always"
        elif kind == faults.SLOW:
            self._slow_s = float(words[0])
        elif kind == faults.LATE:
            self._late_s = float(words[0])
        else:
            self._fault = kind

    def receive_bytes(self, data: bytes, write: Write) -> None:
        """Bytes came in."""
        *lines, self._pending = (self._pending + data).split(b"\n")
        for line in lines:
            if self._fault not in (faults.DEAD_LINE, faults.TIME_OUT):
                self._obey(line, write)

    def _obey(self, line: bytes, write: Write) -> None:
        answer = self._device.ask(line.decode("ascii", "replace").strip())
        if self._fault == faults.ECHO:
            write(line + b"\n")
        if answer is None:
            return
        late_s, self._late_s = self._late_s, 0.0
        time.sleep(self._slow_s + late_s)
        write(self._spoilt(answer.encode("ascii")))

    def _spoilt(self, answer: bytes) -> bytes:
        if self._fault == faults.GARBAGE:
            return bytes(byte ^ 0xA5 for byte in answer) + b"\n"
        if self._fault == faults.CUT_OFF:
            return answer[: len(answer) // 2]
        if self._fault == faults.TERMINATOR:
            return answer + b"\r"
        return answer + b"\n"


class GeneratorPort(ABC):
    """Where a generator can be reached."""

    port: str

    def __init__(self, device: ScpiGenerator) -> None:
        self._link = CommandLink(device)

    def arm_fault(self, line: str) -> None:
        """Arm a fault; see `Link.fault`. `unplugged` cuts every connection."""
        if line == faults.UNPLUGGED:
            self.close()
        else:
            self._link.arm_fault(line)

    @abstractmethod
    def close(self) -> None:
        """Cut every connection."""


class PtyGenerator(GeneratorPort):
    """A generator behind a pseudo-terminal."""

    def __init__(self, device: ScpiGenerator) -> None:
        import tty

        super().__init__(device)
        self._own, self._theirs = os.openpty()
        self._plug, self._pull = os.pipe()
        # Raw at both ends, or the terminal would echo and translate; one end kept open, or it would hang up.
        tty.setraw(self._own)
        tty.setraw(self._theirs)
        self.port = os.ttyname(self._theirs)
        self._thread = threading.Thread(target=self._serve, name="scpi", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Pull the plug."""
        if self._pull < 0:
            return
        # The thread is gone before its descriptors are: else it could read from whatever gets their numbers next.
        os.write(self._pull, b"x")
        self._thread.join()
        for descriptor in (self._theirs, self._own, self._plug, self._pull):
            os.close(descriptor)
        self._pull = -1

    def _serve(self) -> None:
        waiting = select.poll()
        for descriptor in (self._own, self._plug):
            waiting.register(descriptor, select.POLLIN)
        while all(descriptor != self._plug for descriptor, _ in waiting.poll()):
            self._link.receive_bytes(os.read(self._own, 4096), lambda data: os.write(self._own, data))


class SocketGenerator(GeneratorPort):
    """A generator in the network: SCPI on a bare TCP socket, several connections at once."""

    def __init__(self, device: ScpiGenerator) -> None:
        super().__init__(device)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = f"TCPIP0::127.0.0.1::{self._listener.getsockname()[1]}::SOCKET"
        self._stop_own, self._stop = socket.socketpair()
        self._connections: list[socket.socket] = []
        self._thread = threading.Thread(target=self._serve, name="scpi", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Leave the network."""
        if not self._thread.is_alive():
            return
        self._stop.send(b"x")
        self._thread.join()
        for each in (*self._connections, self._listener, self._stop, self._stop_own):
            each.close()

    def _serve(self) -> None:
        while True:
            ready, _, _ = select.select([self._listener, self._stop_own, *self._connections], [], [])
            if self._stop_own in ready:
                return
            for each in ready:
                if each is self._listener:
                    self._connections.append(each.accept()[0])
                else:
                    self._take(each)

    def _take(self, connection: socket.socket) -> None:
        try:
            data = connection.recv(4096)
            if data:
                self._link.receive_bytes(data, connection.sendall)
                return
        except OSError:
            # Whoever asked hung up before the answer.
            pass
        self._connections.remove(connection)
        connection.close()


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


class HislipGenerator(GeneratorPort):
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
                self._link.receive_bytes(
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
