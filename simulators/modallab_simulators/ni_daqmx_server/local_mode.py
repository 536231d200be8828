"""Local mode: the devices behave as if every client had its own driver, and no server between.

A client is a process. Its tasks are its own: no other process can join or clear them, and two may use the same names.
Its bursts stream from it: when it dies they stop where they are and the output holds its last value, its reservations
are given back, and a watchdog it has started runs on and expires. While it is frozen its bursts starve the same way,
but everything it holds stays reserved: only a reset of the device by another process gets through.

Clients come through a relay, since gRPC does not say when a connection ends.
"""

import os
import socket
import threading
import time
from contextlib import suppress
from typing import Any

import psutil

from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.output_task import OutputTask, WatchdogTask

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
