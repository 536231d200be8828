"""What a worker runs: one computation, which can say how far it is and be interrupted."""

import asyncio
import ctypes
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, Literal

from distributed import get_worker

from modallab.core.errors import ModallabError
from modallab.jobs.job import ComputationResult, Notify

TOPIC = "modallab-progress"
"""Under which workers report to the runner how far they are."""
_NOTIFY_EVERY_S = 0.2
STAGE = 100
"""Characters of a stage that are kept."""

Verdict = Literal["done", "failed", "interrupted"]


class Interrupted(BaseException):
    """The job was cancelled or took too long. No `Exception`: a computation that catches all does not catch this."""


class _Running:
    """The computations of this process, by attempt, with the thread each is in."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._threads: dict[str, int] = {}

    def enter(self, attempt: str) -> None:
        with self._lock:
            self._threads[attempt] = threading.get_ident()

    def leave(self, attempt: str) -> None:
        with self._lock:
            self._threads.pop(attempt, None)
            # An interrupt that came with the last instruction must not hit what this thread does next.
            _raise_in(threading.get_ident(), None)

    def imports(self, attempt: str) -> bool:
        """Whether a module is being imported for it."""
        with self._lock:
            frame = sys._current_frames().get(self._threads.get(attempt, 0))
        while frame is not None and "importlib._bootstrap" not in frame.f_code.co_filename:
            frame = frame.f_back
        return frame is not None

    def interrupt(self, attempt: str) -> bool:
        with self._lock:
            thread = self._threads.pop(attempt, None)
            if thread is not None:
                _raise_in(thread, Interrupted)
        return thread is not None


_RUNNING = _Running()


def _raise_in(thread: int, error: type[BaseException] | None) -> None:
    # Python raises it at the thread's next instruction: the numerics need no look-out of their own. NULL takes it back.
    target = ctypes.py_object(error) if error is not None else None
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), target)


async def interrupt_computation(attempt: str) -> bool:
    """Interrupt a computation of this process; False if it is not here. Asynchronous, so that Dask need not wait."""
    # A package of which half was imported would stay, and fail every later computation of this process.
    while _RUNNING.imports(attempt):
        await asyncio.sleep(0.02)
    return _RUNNING.interrupt(attempt)


def compute_attempt(
    attempt: str, work: Callable[[Any, Notify], ComputationResult], payload: Any
) -> tuple[Verdict, ComputationResult | str]:
    """Run one computation on a worker. What it raises is its result: only the loss of a worker is an error to Dask."""
    try:
        _RUNNING.enter(attempt)
        try:
            return "done", work(payload, _progress_notifier(attempt))
        finally:
            _RUNNING.leave(attempt)
    except Interrupted:
        return "interrupted", ""
    except ModallabError as error:
        return "failed", str(error)
    except Exception as error:
        # Whatever else it raises, it will raise again: the runner hears of it, and nothing is tried a second time.
        return "failed", f"{type(error).__name__}: {error}"


def _progress_notifier(attempt: str) -> Notify:
    worker = get_worker()
    last = -_NOTIFY_EVERY_S

    def notify(fraction: float, stage: str = "", /) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _NOTIFY_EVERY_S:
            last = now
            done = min(1.0, max(0.0, float(fraction)))
            worker.log_event(TOPIC, {"attempt": attempt, "progress": done, "stage": stage[:STAGE]})

    return notify
