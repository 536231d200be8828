"""A process that does not outlive the one that started it, at whatever moment that dies.

Whatever is slow to import comes after the watch has begun; so this file needs the standard library only, and what the
process works with comes as bytes.
"""

import os
import pickle
import signal
import sys
import time
from importlib import import_module
from multiprocessing.connection import Connection
from threading import Thread

_PR_SET_PDEATHSIG = 1


def run_owned(life: Connection, owner: int, grace_s: float, name: str, arguments: bytes, *handles: object) -> None:
    """Run a function until it returns or the owner is gone.

    Args:
        life: a pipe whose other end only the owner holds: it breaks when the owner dies.
        owner: the system's number of the owner.
        grace_s: from the owner's death until this process ends, whatever it does; with 0 the system ends it, too.
        name: `module:function`.
        arguments: pickled tuple, after `handles`.
        handles: connections and sockets, which cannot be passed as bytes.
    """
    if grace_s == 0.0:
        _end_with(owner)
    Thread(target=_watch, args=(life, grace_s), name="owner", daemon=True).start()
    module, _, function = name.partition(":")
    getattr(import_module(module), function)(*handles, *pickle.loads(arguments))


def _watch(life: Connection, grace_s: float) -> None:
    try:
        life.recv_bytes()
    except (EOFError, OSError):
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
