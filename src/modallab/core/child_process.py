"""Processes and locks that do not outlive the process that made them, at whatever moment it dies.

Whatever is slow to import comes after the watch has begun; so this file needs the standard library only, and what the
process works with comes as bytes.
"""

import multiprocessing
import os
import pickle
import signal
import sys
import time
from contextlib import suppress
from importlib import import_module
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import Event, Thread
from typing import Self

from modallab.core.blas_threads import limit_to_one_thread

_PR_SET_PDEATHSIG = 1


def start_child_process(
    name: str,
    target: str,
    handles: tuple[object, ...],
    arguments: bytes,
    *,
    grace_s: float = 0.0,
    daemon: bool = False,
) -> tuple[BaseProcess, Connection]:
    """Start a process that ends with this one.

    Args:
        name: of the process.
        target: `module:function`, called with the handles and the arguments.
        handles: connections and sockets, which cannot be passed as bytes.
        arguments: pickled tuple.
        grace_s: it lives so long at most after this process has died, if its function was called by then; with 0 the
            system ends it, too, with the thread that calls this.
        daemon: whether it is ended when this process ends in good order.

    Returns:
        the process, and what must be kept as long as it is to live.
    """
    context = multiprocessing.get_context("spawn")
    watched, life = context.Pipe(duplex=False)
    process = context.Process(
        target=run_child_process,
        args=(watched, os.getpid(), grace_s, target, arguments, *handles),
        name=name,
        daemon=daemon,
    )
    process.start()
    watched.close()
    return process, life


def run_child_process(
    life: Connection, owner: int, grace_s: float, target: str, arguments: bytes, *handles: object
) -> None:
    """Run a function until it returns or the owner is gone.

    Args:
        life: a pipe whose other end only the owner holds: it breaks when the owner dies.
        owner: the system's number of the owner.
        grace_s: from the owner's death until this process ends, whatever it does; none while it only imports. With 0
            the system ends it, too.
        target: `module:function`.
        arguments: pickled tuple, after `handles`.
        handles: connections and sockets, which cannot be passed as bytes.
    """
    if grace_s == 0.0:
        _end_with(owner)
    begun = Event()
    Thread(target=_watch, args=(life, begun, grace_s), name="owner", daemon=True).start()
    limit_to_one_thread()
    module, _, name = target.partition(":")
    function, known = getattr(import_module(module), name), pickle.loads(arguments)
    begun.set()
    function(*handles, *known)


def _watch(life: Connection, begun: Event, grace_s: float) -> None:
    try:
        life.recv_bytes()
    except (EOFError, OSError):
        # What has not begun holds nothing that it would have to leave in good order.
        if begun.is_set():
            time.sleep(grace_s)
        os._exit(1)


def _end_with(owner: int) -> None:
    # The pipe is enough unless this process is frozen or a library holds the interpreter's lock.
    if sys.platform != "linux":
        return
    import ctypes

    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL))
    # It may have died before that was said.
    if os.getppid() != owner:
        os._exit(1)


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


class FileLock:
    """An exclusive lock on a small file; the operating system lets go of it when the holder dies, however it dies."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._descriptor: int | None = None

    def acquire(self) -> bool:
        """Take the lease; False if another process, or another `FileLock` of this one, holds it."""
        while True:
            descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                _lock(descriptor)
            except OSError:
                os.close(descriptor)
                return False
            if self._is_named(descriptor):
                self._descriptor = descriptor
                return True
            # Its holder removed the file just now: who comes next makes a new one, and would hold that.
            os.close(descriptor)

    def release(self) -> None:
        """Let go and remove the file; nothing to do if it is not held."""
        if self._descriptor is None:
            return
        if sys.platform != "win32":
            # While it is still held, or a file that another has taken since would be removed.
            self._path.unlink(missing_ok=True)
        os.close(self._descriptor)
        self._descriptor = None
        if sys.platform == "win32":
            # A file that is open cannot be removed there: nor can one that another holds.
            with suppress(OSError):
                self._path.unlink(missing_ok=True)

    def _is_named(self, descriptor: int) -> bool:
        try:
            return os.path.samestat(os.fstat(descriptor), self._path.stat())
        except FileNotFoundError:
            return False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()
