"""One attempt at one job: load, have it computed, keep, commit."""

import asyncio
import ctypes
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError
from typing import Any, Literal

from distributed import Client, Future, get_worker
from distributed.comm.core import CommClosedError
from distributed.scheduler import KilledWorker

from modallab.core.errors import DatabaseLostError, JobError, ModallabError
from modallab.jobs.job import ComputationResult, JobDefinition, ProgressCallback
from modallab.jobs.leases import JobLeases, LeasedJob

TOPIC = "modallab-progress"
"""Under which workers report to the runner how far they are."""
_NOTIFY_EVERY_S = 0.2
STAGE = 100
"""Characters of a stage that are kept."""

Verdict = Literal["done", "failed", "interrupted"]


class JobInterrupted(BaseException):
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
                _raise_in(thread, JobInterrupted)
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
    attempt: str, work: Callable[[Any, ProgressCallback], ComputationResult], payload: Any
) -> tuple[Verdict, ComputationResult | str]:
    """Run one computation on a worker. What it raises is its result: only the loss of a worker is an error to Dask."""
    try:
        _RUNNING.enter(attempt)
        try:
            return "done", work(payload, _progress_notifier(attempt))
        finally:
            _RUNNING.leave(attempt)
    except JobInterrupted:
        return "interrupted", ""
    except ModallabError as error:
        return "failed", str(error)
    except Exception as error:
        # Whatever else it raises, it will raise again: the runner hears of it, and nothing is tried a second time.
        return "failed", f"{type(error).__name__}: {error}"


def _progress_notifier(attempt: str) -> ProgressCallback:
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


MACHINE_LOST = (KilledWorker, CommClosedError, CancelledError, TimeoutError, OSError)
"""What says that a machine failed, not the computation: the job is tried again."""
AGAIN_S = 0.5


class JobAttempt:
    """A job while this runner holds it. `progress` and `stage` are what its worker last said."""

    def __init__(self, taken: LeasedJob, kind: JobDefinition, leases: JobLeases, client: Client) -> None:
        self.taken = taken
        self.progress, self.stage = 0.0, ""
        self._kind = kind
        self._leases = leases
        self._client = client
        self._future: Future[Any] | None = None
        self._begun = time.monotonic()
        self._lock = threading.Lock()
        self._abandoned = threading.Event()
        self._interrupted = False

    @property
    def is_overdue(self) -> bool:
        """Whether it goes on for longer than its kind allows."""
        return time.monotonic() - self._begun > self._kind.limit_s

    def run(self) -> None:
        """Do all of it. However it ends, the table says so."""
        try:
            payload = self._load()
        except DatabaseLostError as error:
            self._give_back(str(error), counts=False)
        except ModallabError as error:
            self._fail(str(error))
        except Exception as error:
            self._fail(f"{type(error).__name__}: {error}")
        else:
            self._compute(payload)

    def _load(self) -> Any:
        job = self.taken.job
        payload = self._kind.load(dict(job.parameters), job.inputs)
        # Looked at last: what changes from here on is not in the payload.
        if job.revision and self._kind.revision(job.inputs) != job.revision:
            raise JobError("the valid blocks have changed since the order", where=job.id, remedy="order it again")
        return payload

    def give_back(self) -> None:
        """The runner stops, or its scheduler is gone: give the job back."""
        self._abandoned.set()
        self.interrupt()

    def interrupt(self) -> None:
        """Stop the computation; again and again if need be, since it may only just have begun."""
        with self._lock:
            self._interrupted = True
        if self._future is None or self._client.status != "running":
            return
        self._client.run(interrupt_computation, self.taken.attempt_name, wait=False, on_error="ignore")
        self._future.cancel(force=True, msg="interrupted")

    def _compute(self, payload: Any) -> None:
        try:
            verdict, found = self._ask(payload)
        except MACHINE_LOST as error:
            self._without_result(error)
            return
        except Exception as error:
            # It cannot be sent, or the worker cannot take it: nor could it the next time.
            self._fail(f"{type(error).__name__}: {error}")
            return
        if verdict == "done" and isinstance(found, ComputationResult):
            self._keep(found)
        elif verdict == "failed":
            self._fail(str(found))
        else:
            self._without_result(None)

    def _ask(self, payload: Any) -> tuple[str, ComputationResult | str]:
        name = self.taken.attempt_name
        with self._lock:
            if self._interrupted:
                return "interrupted", ""
            future = self._client.submit(compute_attempt, name, self._kind.compute, payload, key=name, pure=False)
            self._future = future
        try:
            return future.result()
        finally:
            future.release()

    def _without_result(self, error: BaseException | None) -> None:
        # Of a job that was cancelled the fence has moved on, and none of these changes anything.
        if self._client.status != "running":
            self._give_back("the scheduler ended", counts=True)
        elif self._abandoned.is_set():
            self._give_back("the runner was stopped", counts=False)
        elif self.is_overdue:
            self._fail(f"the job exceeded {self._kind.limit_s:g} s, and was stopped")
        else:
            self._give_back(f"a worker was lost ({error})", counts=True)

    def _keep(self, computed: ComputationResult) -> None:
        try:
            result = self._kind.keep(self.taken.attempt_name, computed)
        except ModallabError as error:
            self._fail(str(error))
        except Exception as error:
            self._fail(f"{type(error).__name__}: {error}")
        else:
            self._commit(lambda: self._leases.complete(self.taken, result))

    def _fail(self, error: str) -> None:
        self._commit(lambda: self._leases.fail(self.taken, error))

    def _give_back(self, why: str, *, counts: bool) -> None:
        self._commit(lambda: self._leases.give_back(self.taken, why, counts=counts))

    def _commit(self, change: Callable[[], bool]) -> None:
        """Commit how it ended, as soon as the database is there: what was computed is not lost with a server.

        Raises:
            StorageError: it could not be committed; then the lease runs out, and the job is taken again.
        """
        while True:
            try:
                change()
            except DatabaseLostError:
                if self._abandoned.wait(AGAIN_S):
                    raise
            else:
                return
