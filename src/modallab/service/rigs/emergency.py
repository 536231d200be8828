"""The emergency stop of one rig: at 0 V and latched, whatever disk, database and the rig's process do."""

from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet
from threading import Lock, Thread

from modallab.acquisition.process.rig_process import RigProcess
from modallab.acquisition.process.trip import TripLatch
from modallab.core.errors import BenchError, ModallabError, StorageError

ANSWER_S = 6.0
"""A device that has not brought its output to 0 V by then is not known to do so."""


class EmergencyStop:
    """Requests that come while a stop goes on share it. Once the rig is latched, a further one writes nothing."""

    def __init__(self, latch: TripLatch, notify: Callable[[str, str], None]) -> None:
        """`notify` is called with reason and operator of every stop that did something."""
        self._latch = latch
        self._notify = notify
        self._lock = Lock()
        self._going_on: Future[None] | None = None
        self._stopped: RigProcess | None = None
        self._unwritten = ""

    def stop_output(self, process: RigProcess | None, reason: str, operator: str) -> None:
        """Bring the output to 0 V, and latch.

        Raises:
            ModallabError: the output could not be reached, or nobody knows within `ANSWER_S`.
        """
        with self._lock:
            future = self._going_on
            if future is None:
                future = self._going_on = Future()
                # On a thread of its own: a process that is stuck may hold it up, but not whoever asks.
                Thread(target=self._work, args=(future, process, reason, operator), name="stop", daemon=True).start()
        try:
            future.result(ANSWER_S)
        except NotYet:
            raise BenchError(
                f"the output has not confirmed 0 V within {ANSWER_S:g} s", remedy="switch the amplifier off"
            ) from None

    def require_latch(self) -> None:
        """Write a trip that the disk did not take, before anything is driven again.

        Raises:
            StorageError: it still does not.
        """
        if self._unwritten:
            self._latch.trip("emergency stop", self._unwritten)
            self._unwritten = ""

    def reset(self) -> bool:
        """Forget it; whether there was one that is not on the disk."""
        self._stopped, unwritten, self._unwritten = None, self._unwritten, ""
        return bool(unwritten)

    def _work(self, future: "Future[None]", process: RigProcess | None, reason: str, operator: str) -> None:
        try:
            self._stop(process, reason, operator)
        except Exception as error:
            self._end(future, error)
        else:
            self._end(future, None)

    def _end(self, future: "Future[None]", error: Exception | None) -> None:
        with self._lock:
            self._going_on = None
        if error is None:
            future.set_result(None)
        else:
            future.set_exception(error)

    def _stop(self, process: RigProcess | None, reason: str, operator: str) -> None:
        if process is not None and process is self._stopped and (self._latch.is_tripped or self._unwritten):
            if process.supervisor is not None:
                process.supervisor.zero_output()
            return
        if process is None and self._latch.is_tripped:
            return
        try:
            self._command(process, reason)
        except StorageError:
            # The output is at 0 V by now. A full disk mostly has room for a latch that says nothing.
            self._unwritten = "" if self._latch.is_tripped else reason
        finally:
            self._notify(reason, operator)
        self._stopped = process

    def _command(self, process: RigProcess | None, reason: str) -> None:
        if process is None:
            self._latch.trip("emergency stop", reason)
            return
        try:
            process.emergency_stop(reason)
        except BenchError as error:
            if not _died_at_rest(error):
                raise


def _died_at_rest(error: ModallabError) -> bool:
    # Its process is dead, and its output ended with it or was brought to 0 V from outside.
    return isinstance(error.__cause__, OSError | EOFError) and "could not be brought to 0 V" not in error.what
