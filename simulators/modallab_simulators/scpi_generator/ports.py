"""Where a generator can be reached: a pseudo-terminal, which a serial package opens as it opens a port, or a socket."""

import os
import select
import socket
import threading

from modallab_simulators.scpi_generator.device import ScpiGenerator
from modallab_simulators.scpi_generator.link import Port


class PtyGenerator(Port):
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
            self._link.take(os.read(self._own, 4096), lambda data: os.write(self._own, data))


class SocketGenerator(Port):
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
                self._link.take(data, connection.sendall)
                return
        except OSError:
            # Whoever asked hung up before the answer.
            pass
        self._connections.remove(connection)
        connection.close()
