"""What runs in the supervisor's process: it ends an excitation that nobody answers for any more.

Some outputs go on when the process that drives them dies, others hold their last value. The supervisor opens a handle
of its own before anything moves, and then only waits: for the rig's process to die (the pipe between them breaks at
once), to be frozen, or to give no sign of life while a test is on, for the owner to die, or for an emergency stop.

It is in a session of its own, so that what kills or freezes the whole process group of the service does not reach it.
It leaves when the rig's process has left, so that it outlives nobody for long.
"""

import os
import signal
import sys
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Literal, NoReturn

import psutil

from modallab.acquisition.process.trip import TripLatch
from modallab.bench.loader import open_output
from modallab.bench.protocol import OutputHandle
from modallab.core.errors import BenchError, ModallabError
from modallab.core.rig import Rig

TIMEOUT_S = 1.0
"""A rig's process that is at work and says nothing for so long does not do its work."""

DIED = "the acquisition process died while it drove"
FROZEN = "the acquisition process was frozen while it drove"
TIMED_OUT = f"the acquisition process gave no sign of life for {TIMEOUT_S:g} s while it drove"

BEAT_S = 0.1
TRIES = 3

Sign = Literal["driving", "working", "idle"]
Order = Literal["zero", "leave"]


def supervise_output(watched: Connection, owner: Connection, url: str, rig: Rig, data_folder: Path) -> None:
    """What runs in the supervisor's process."""
    _stand_apart()
    try:
        handle = open_output(url, rig)
    except ModallabError as error:
        owner.send(error)
        return
    if handle is None:
        owner.send(BenchError(f"{url} has no output to supervise"))
        return
    owner.send("ready")
    cause = None
    try:
        cause = _watch(watched, owner, handle, TripLatch(data_folder, url))
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        # The rig's process has left or died: nobody needs what it may still hold. To end the output comes first.
        _try_call(handle.release)
        if cause is not None:
            _try_call(cause)
        handle.close()


def _stand_apart() -> None:
    """Away from the process group and the terminal of the service: neither their signals nor their end come here."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)
    if sys.platform == "win32":
        import ctypes

        getattr(ctypes, "windll").kernel32.FreeConsole()  # noqa: B009
    else:
        os.setsid()


def _leave(_number: int, _frame: object) -> NoReturn:
    # With 0 V on the output, by the way every other end takes.
    raise SystemExit


def _watch(watched: Connection, owner: Connection, handle: OutputHandle, latch: TripLatch) -> Callable[[], None] | None:
    """Wait until the rig's process is gone, or the owner asks to leave.

    Returns:
        What is left to do once the output is at 0 V.
    """
    received_s = time.monotonic()
    sign: Sign = "idle"
    process: psutil.Process | None = None
    ends = [watched, owner]
    while True:
        ready = wait(ends, timeout=BEAT_S)
        try:
            if watched in ready:
                message: Sign | int = watched.recv()
                received_s = time.monotonic()
                if isinstance(message, int):
                    process = _find_process(message)
                else:
                    sign = message
        except (EOFError, OSError):
            return partial(latch.trip, "death", DIED) if sign == "driving" else None
        try:
            if owner in ready:
                order: Order = owner.recv()
                if order == "leave":
                    return None
                owner.send(_try_call(handle.zero))
        except (EOFError, OSError):
            # The rig's process hears of it too, and ends its run in good order; if it can't, somebody must be there.
            ends = [watched]
            _try_call(handle.zero)
        frozen = sign != "idle" and not ready and _is_frozen(process)
        if sign != "idle" and (frozen or time.monotonic() - received_s > TIMEOUT_S):
            _try_call(handle.zero)
            if sign == "driving":
                _try_call(partial(latch.trip, "time-out", FROZEN if frozen else TIMED_OUT))
            sign = "idle"


def _find_process(process: int) -> psutil.Process | None:
    try:
        return psutil.Process(process)
    except psutil.Error:
        return None


def _is_frozen(process: psutil.Process | None) -> bool:
    # One who is frozen can't be merely slow: there is no need to wait for a sign of life.
    try:
        return process is not None and process.status() == psutil.STATUS_STOPPED
    except psutil.Error:
        return False


def _try_call(call: Callable[[], None]) -> ModallabError | None:
    failed: ModallabError | None = None
    for _ in range(TRIES):
        try:
            call()
        except ModallabError as error:
            failed = error
        else:
            return None
    return failed
