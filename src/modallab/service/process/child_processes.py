"""A process of the service: started again when it dies, and timed while it gives no sign of life."""

import json
import logging
import multiprocessing
import pickle
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import Lock

import psutil

from modallab.core.child_process import start_child_process

LOG = logging.getLogger(__name__)
NAME = "service.processes"
END_S = 5.0
CLOCK_S = 2.0
"""The moment a process began is known to so much."""
Known = tuple[int, float, bool]
"""The system's number of a process, when it began, and whether it leaves by itself once its owner is dead."""


class ProcessList:
    """The list of one data folder. Only who holds the folder's lock may use it."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / NAME
        self._known: dict[str, Known] = {}

    def end_all(self) -> tuple[int, ...]:
        """End those that still live: their service is dead, or the lock would be held. Returns their numbers.

        A rig's process brings its output to 0 V, commits and leaves; it is ended if it is frozen or does not leave.
        """
        living = [(process, leaves) for pid, began_s, leaves in self._read() if (process := _is_living(pid, began_s))]
        at_work = [process for process, leaves in living if leaves and not _is_frozen(process)]
        _, stuck = psutil.wait_procs(at_work, timeout=END_S)
        left = [process for process, _ in living if process not in at_work or process in stuck]
        for process in left:
            LOG.warning("process %d remains from an earlier service of this folder, and is ended", process.pid)
            with suppress(psutil.NoSuchProcess):
                process.kill()
        psutil.wait_procs(left, timeout=END_S)
        self._path.unlink(missing_ok=True)
        return tuple(process.pid for process in left)

    def add(self, name: str, pid: int | None, *, leaves: bool = False) -> None:
        """A process was started; `leaves` if it leaves by itself, in good order, once its owner is dead."""
        if pid is None or self._known.get(name, (0,))[0] == pid:
            return
        try:
            self._known[name] = (pid, psutil.Process(pid).create_time(), leaves)
            self._path.write_text(json.dumps(list(self._known.values())), encoding="ascii")
        except (psutil.Error, OSError) as error:
            # It ends by itself with its owner; this list is for whatever keeps it from doing so.
            LOG.warning("process %d was not noted: %s", pid, error)

    def close(self) -> None:
        """None is left."""
        self._path.unlink(missing_ok=True)

    def _read(self) -> list[Known]:
        try:
            rows = json.loads(self._path.read_text(encoding="ascii"))
            return [(int(pid), float(began_s), leaves == [True]) for pid, began_s, *leaves in rows]
        except (OSError, ValueError, TypeError):
            return []


def _is_frozen(process: psutil.Process) -> bool:
    try:
        return process.status() == psutil.STATUS_STOPPED
    except psutil.Error:
        return False


def _is_living(pid: int, began_s: float) -> psutil.Process | None:
    try:
        process = psutil.Process(pid)
        # A number that is used again is another process.
        return process if abs(process.create_time() - began_s) < CLOCK_S else None
    except psutil.Error:
        return None


AGAIN_S = 0.2
MOST_S = 10.0
STEADY_S = 10.0
"""Whoever lives so long is started again without delay: that cannot happen more often than every `MOST_S`."""
LEAVE_S = 1.5
"""Until a process that was asked to leave is ended: what it holds is in the database or on the disk already."""
AT_MOST = 5.0
"""However busy the machine: so many times the time-out, by the clock, is too long."""


class SupervisedProcess:
    """One such process. `started` is called with this end of its pipe each time; None through it asks it to leave."""

    def __init__(
        self,
        name: str,
        target: str,
        arguments: tuple[object, ...],
        started: Callable[[Connection], None] = lambda _: None,
        *,
        handles: tuple[object, ...] = (),
        grace_s: float = 0.0,
    ) -> None:
        """Nothing is started yet.

        Args:
            name: of the process.
            target: `module:function`, called with its end of the pipe, the handles and the arguments.
            arguments: what can be pickled.
            started: called with this end of its pipe.
            handles: sockets.
            grace_s: it lives so long at most after this process has died.
        """
        self.name = name
        self._target = target
        self._arguments = pickle.dumps(arguments)
        self._handles = handles
        self._grace_s = grace_s
        self._started = started
        self._pause_s = AGAIN_S
        self._next_s = 0.0
        self._began_s = 0.0
        self._leave_by_s = 0.0
        self.process: BaseProcess | None = None
        self._connection: Connection | None = None
        self._life: Connection | None = None
        # It is started by one thread and asked to leave by another: never started after that, nor half started then.
        self._lock = Lock()
        self._leaving = False

    @property
    def pid(self) -> int | None:
        """The system's number of it; None while it is not there."""
        process = self.process
        return process.pid if process is not None and process.is_alive() else None

    @property
    def used_s(self) -> float:
        """Seconds of the processor it has used so far; 0 while it is not there."""
        try:
            times = psutil.Process(self.pid).cpu_times() if self.pid is not None else None
        except psutil.Error:
            return 0.0
        return 0.0 if times is None else times.user + times.system

    def check_now(self) -> None:
        """Start it, if it is not there and its time has come; never once it was asked to leave."""
        with self._lock:
            if not self._leaving:
                self._look()

    def _look(self) -> None:
        if self.process is not None and self.process.is_alive():
            return
        now = time.monotonic()
        if self.process is not None and self._connection is not None:
            LOG.warning("%s ended with %s", self.name, self.process.exitcode)
            # Not closed: whoever listens to it hears its end by himself, and a number in use is never given again.
            self._connection = None
            self._pause_s = AGAIN_S if now - self._began_s > STEADY_S else min(2 * self._pause_s, MOST_S)
            self._next_s = now + self._pause_s
        if now >= self._next_s:
            self._start()

    def request_exit(self) -> None:
        """Ask it, and wait for nothing but a start that is under way."""
        with self._lock:
            self._leaving = True
        self._leave_by_s = time.monotonic() + LEAVE_S
        if self._connection is not None:
            with suppress(OSError):
                self._connection.send(None)

    def close(self) -> None:
        """Wait until it has left as it was asked to; if it does not, end it."""
        if self.process is None:
            return
        self.process.join(max(0.0, self._leave_by_s - time.monotonic()))
        if self.process.is_alive():
            self.process.kill()
            self.process.join()

    def _start(self) -> None:
        ours, theirs = multiprocessing.get_context("spawn").Pipe()
        handles = (theirs, *self._handles)
        # Held as long as this process lives, and closed with it.
        self.process, self._life = start_child_process(
            self.name, self._target, handles, self._arguments, grace_s=self._grace_s
        )
        theirs.close()
        self._connection, self._began_s = ours, time.monotonic()
        self._started(self._connection)


class HeartbeatTimer:
    """Times how long another process has given no sign of life.

    On a busy machine a living process was seen to give no sign of life for two seconds. Whoever listens was kept
    waiting as well, then; so between two looks at most one long look's time is counted. And a process that has used
    the processor since the last look is not frozen, though it did not get to speak: that time is not counted either.
    """

    def __init__(self, allowed_s: float, look_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin.

        Args:
            allowed_s: a counted time without a sign longer than this is too long.
            look_s: between two looks, if nobody is kept waiting.
            clock: monotonic, in seconds.
        """
        self._allowed_s = allowed_s
        self._count_s = 2.0 * look_s
        self._clock = clock
        self._looked_s = clock()
        self._received_s = self._looked_s
        self._used_s = 0.0
        self.counted_s = 0.0

    def check_now(self, received_s: float, used_s: float) -> bool:
        """Look again. Whether the other has given no sign of life for too long.

        Args:
            received_s: when a message was received last.
            used_s: of the processor, by it and so far.
        """
        now = self._clock()
        passed = min(now - self._looked_s, self._count_s)
        self._looked_s = now
        if received_s != self._received_s:
            self._received_s, self.counted_s = received_s, 0.0
        elif used_s == self._used_s:
            self.counted_s += passed
        self._used_s = used_s
        return self.counted_s > self._allowed_s or now - received_s > AT_MOST * self._allowed_s
