"""The controller of one rig: it owns the rig's process, begins runs, passes on commands and records events."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Event as Flag
from threading import Lock, Thread

from modallab.acquisition.process.rig_process import RigProcess
from modallab.acquisition.process.trip import TripLatch
from modallab.bench.protocol import BenchInfo
from modallab.core.documents.rigs import RigState
from modallab.core.documents.runs import Command
from modallab.core.errors import ModallabError
from modallab.core.rig import Rig
from modallab.service.errors import ConflictError, NotFoundError, RigUnavailableError
from modallab.service.rigs.active_run import ActiveRun, RequestedRun
from modallab.service.rigs.control import ControllerState, StartRun
from modallab.service.rigs.emergency import EmergencyStop
from modallab.service.rigs.run_log import RunLog
from modallab.storage.recorder import utc_now

LOG = logging.getLogger(__name__)

LOOK_S = 0.1
BEGIN_S = 20.0
"""Until a run must have begun: the rig's process answers within milliseconds unless its disk or device is stuck."""
REOPEN_S = 5.0
"""Between two tries to open a bench that could not be opened."""


@dataclass(frozen=True, slots=True)
class ServedRig:
    """A rig of the service: its id, what stands there, the address, and where it records."""

    id: str
    rig: Rig
    url: str
    folder: Path


class RigController:
    """One rig. Its thread opens the bench, keeps it open, and runs one plan after the other."""

    def __init__(
        self,
        bench: ServedRig,
        run_log: RunLog,
        ended: Callable[[str], None],
        begin_s: float = BEGIN_S,
    ) -> None:
        """Begin to open the bench.

        Args:
            bench: the rig.
            run_log: where it writes.
            ended: called with the name of every run that has ended.
            begin_s: until a run must have begun.
        """
        self._begin_s = begin_s
        self.bench = bench
        self.latch = TripLatch(bench.folder, bench.url)
        self._run_log = run_log
        self._stop = EmergencyStop(self.latch, partial(run_log.tripped, bench.id))
        self._ended = ended
        self._state: RigState = "starting"
        self._error = ""
        self._since = utc_now()
        self._active: ActiveRun | None = None
        self._process: RigProcess | None = None
        self._info: BenchInfo | None = None
        self._requested: SimpleQueue[RequestedRun] = SimpleQueue()
        self._kept: RequestedRun | None = None
        self._last_requested: RequestedRun | None = None
        self._starting = Lock()
        self._closing = Flag()
        self._thread = Thread(target=self._work, name=f"controller {bench.id}", daemon=True)
        self._thread.start()

    @property
    def driving(self) -> bool:
        """Whether a test that moves the output is on."""
        active = self._active
        return active is not None and active.plan.kind != "impact"

    @property
    def pid(self) -> int | None:
        """The system's number of the rig's process."""
        process = self._process
        return None if process is None else process.process.pid

    def state(self) -> ControllerState:
        """How the rig stands."""
        active = self._active
        run = active.run if active is not None else None
        bench = self.bench
        return ControllerState(
            bench.id, bench.rig, bench.url, self._state, self._info, run or None, self._error, self._since
        )

    def wait_until_settled(self, patience_s: float) -> ControllerState:
        """Wait until the bench is open or cannot be opened, and no run is on; how it stands then."""
        end = time.monotonic() + patience_s
        while self._state in ("starting", "running") and time.monotonic() < end:
            time.sleep(LOOK_S)
        return self.state()

    def start(self, order: StartRun, operator: str) -> str:
        """Begin a run and wait until it has a name; of one that was begun under the same key before, its name.

        Raises:
            IdempotencyError: another request was sent with its key.
            TrippedError: reset first.
            ConflictError: a run is active.
            RigUnavailableError: the bench is not open.
            ModallabError: what kept it from beginning.
        """
        before = self._before(order)
        if before is not None:
            return before
        with self._starting:
            # Whoever waited here may have waited for the same request.
            return self._before(order) or self._start(order, operator)

    def _before(self, order: StartRun) -> str | None:
        requested = self._last_requested
        if requested is not None and requested.is_of(order):
            return requested.wait_for_name(self._begin_s)
        return None if order.key is None else self._run_log.repository.run_of(order.key)

    def _start(self, order: StartRun, operator: str) -> str:
        self._stop.require_latch()
        self.latch.require_reset()
        if self._active is not None:
            raise ConflictError(
                f"run {self._active.run} is going on", where=self.bench.id, remedy="wait for its end, or stop it"
            )
        if self._state != "idle":
            raise RigUnavailableError.of(f"the rig is {self._state}", self._error, self.bench.id)
        requested = self._last_requested = RequestedRun(order, operator)
        self._requested.put(requested)
        return requested.wait_for_name(self._begin_s)

    def command(self, run: str, command: Command, operator: str) -> None:
        """Pass a command on to the active run.

        Raises:
            IllegalTransitionError: the run is in no state for it.
            ConflictError: the run is not the active one.
        """
        active, process = self._active, self._process
        if active is None or process is None or active.run != run:
            raise ConflictError(f"run {run} is not going on", where=self.bench.id, remedy="read the list of runs")
        active.command(process, command, operator)

    def emergency_stop(self, reason: str, operator: str) -> None:
        """Bring the output to 0 V and latch, whatever else goes on.

        Raises:
            ModallabError: the output could not be reached.
        """
        self._stop.stop_output(self._process, reason, operator)

    def reset(self, reason: str, operator: str) -> None:
        """Let it be driven again.

        Raises:
            NotFoundError: it is not tripped.
        """
        unwritten = self._stop.reset()
        if self.latch.reset() is None and not unwritten:
            raise NotFoundError("the rig is not tripped", where=self.bench.id, remedy="no reset is needed")
        self._run_log.reset(self.bench.id, reason, operator)

    def revise(self, rig: Rig, reason: str, operator: str) -> None:
        """Go on with another description of what stands on the bench, which is opened again for it.

        Raises:
            ConflictError: a run is active, or the description is of another rig.
            StorageError: it could not be kept.
        """
        if rig.name != self.bench.rig.name:
            raise ConflictError(
                f"the description is of {rig.name!r}, the rig is {self.bench.rig.name!r}",
                where=self.bench.id,
                remedy="send it with the rig's name; another rig needs another service",
            )
        with self._starting:
            if self._active is not None or not self._requested.empty():
                raise ConflictError("a run is active", where=self.bench.id, remedy="wait for its end, or stop it")
            if rig == self.bench.rig:
                return
            self._run_log.revisions.add(self.bench.id, rig, reason, operator)
            self.bench = replace(self.bench, rig=rig)
            self._is("starting")
            process = self._process
        if process is not None:
            process.request_exit()

    def request_close(self) -> None:
        """End what is active as interrupted, bring the output to zero, release the bench; waits for nothing."""
        self._closing.set()
        process = self._process
        if process is not None:
            process.request_exit()

    def close(self) -> None:
        """As `request_close`, and wait until it has happened."""
        # The thread that follows the run also reads its end: two readers of one pipe take each other's reports.
        self.request_close()
        self._thread.join(BEGIN_S)

    def _work(self) -> None:
        while not self._closing.is_set():
            try:
                self._open_and_serve()
            except ModallabError as error:
                self._is("unavailable", str(error))
                self._reject_kept(error)
                LOG.warning("rig %s: %s", self.bench.id, error)
            except Exception:
                self._is("unavailable", "unexpected error, see the log")
                LOG.exception("rig %s", self.bench.id)
            self._closing.wait(REOPEN_S if self._state == "unavailable" else 0.0)

    def _open_and_serve(self) -> None:
        process = self._process = RigProcess(self.bench.url, self.bench.rig, self.bench.folder)
        try:
            self._info = process.info
            self._is("idle")
            while not self._closing.is_set() and process.process.is_alive():
                requested = self._next()
                if requested is not None and requested.claim() and not self._run(process, requested):
                    break
        finally:
            self._process = None
            self._is("starting")
            process.close()

    def _next(self) -> RequestedRun | None:
        kept, self._kept = self._kept, None
        try:
            return kept or self._requested.get(timeout=LOOK_S)
        except Empty:
            return None

    def _run(self, process: RigProcess, requested: RequestedRun) -> bool:
        """Whether the process is of use for another run."""
        active = ActiveRun(self.bench.id, requested.order, requested.operator, self._run_log)
        self._active = active
        self._is("running")
        try:
            kept_from_it = active.run_to_end(process, requested.begun)
        finally:
            self._active = None
            self._is("idle" if process.process.is_alive() else "starting")
        if active.run:
            self._ended(active.run)
        return kept_from_it is None or self._reject(requested, kept_from_it)

    def _reject(self, requested: RequestedRun, error: ModallabError) -> bool:
        if requested.again or not isinstance(error.__cause__, EOFError | OSError):
            requested.reject(error)
            return True
        # The pipe broke: it had left while nothing was on, as it does when a busy machine lets nobody speak to it for
        # long, and may still be about to end.
        requested.return_to_queue()
        self._kept = requested
        return False

    def _reject_kept(self, error: ModallabError) -> None:
        kept, self._kept = self._kept, None
        if kept is not None:
            kept.reject(error)

    def _is(self, state: RigState, error: str = "") -> None:
        if (state, error) != (self._state, self._error):
            self._state, self._error, self._since = state, error, utc_now()
            self._run_log.rig_state(self.bench.id, state, error)
