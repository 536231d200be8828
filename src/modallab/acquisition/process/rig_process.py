"""A rig's own process, seen from the process that owns it."""

import atexit
import multiprocessing
import pickle
import weakref
from collections.abc import Generator
from contextlib import suppress
from pathlib import Path
from threading import Event as Flag
from threading import Lock, Thread
from typing import Self

from modallab.acquisition.procedures.struck_point.participation import ExpectedModes
from modallab.acquisition.process.controls import RunControls
from modallab.acquisition.process.output_supervisor import start_supervisor, zero_output_of_dead_process
from modallab.acquisition.process.owner_link import (
    HEARTBEAT_S,
    BenchOpened,
    CloseOrder,
    EmergencyStopOrder,
    Message,
    OwnerHeartbeat,
    Report,
    RunEnded,
    RunPlan,
)
from modallab.acquisition.process.trip import Trip, TripLatch
from modallab.bench.protocol import BenchInfo
from modallab.core.child_process import start_child_process
from modallab.core.documents.runs import AbortRun, StopRun
from modallab.core.errors import BenchError, ModallabError
from modallab.core.events import Event
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.storage import Store

SERVE = "modallab.acquisition.process.child:serve_rig"
POLL_S = 0.2
LEAVE_S = 10.0
OWNERLESS_S = 10.0
"""From its owner's death on: to bring the output to 0 V, commit and leave by itself."""

_OPEN: "weakref.WeakSet[RigProcess]" = weakref.WeakSet()


class RigProcess(RunControls):
    """One bench in one spawned process: commands go in, events come out.

    However the owner ends, the process brings the output to zero, commits what it has, and leaves: on `close`, when the
    pipe breaks, or when the heartbeat is gone. It starts at once and opens the bench meanwhile; `run` waits for it.
    """

    def __init__(self, url: str, rig: Rig, data_folder: Path) -> None:
        """Start the process for the bench at `url`, which records into `data_folder`."""
        super().__init__(data_folder)
        self._url, self._rig = url, rig
        self._info: BenchInfo | None = None
        self.latch = TripLatch(data_folder, url)
        self.supervisor, self.supervision = start_supervisor(url, rig, data_folder)
        life_line = None if self.supervisor is None else self.supervisor.life_line
        self._connection, theirs = multiprocessing.get_context("spawn").Pipe()
        known = pickle.dumps((url, rig, data_folder, self.supervision))
        self.process, self._life = start_child_process(
            f"rig {rig.name}", SERVE, (theirs, life_line), known, grace_s=OWNERLESS_S
        )
        # Only the child may hold the other ends, or its death would not be heard.
        theirs.close()
        if self.supervisor is not None:
            self.supervisor.close_own_copy()
        self._sending = Lock()
        self._closed = Flag()
        Thread(target=self._beat, name="heartbeat", daemon=True).start()
        _OPEN.add(self)

    @property
    def rig(self) -> Rig:
        """What stands on the bench."""
        return self._rig

    @property
    def info(self) -> BenchInfo:
        """What the bench is; waits until it is open.

        Raises:
            BenchError: it could not be opened.
        """
        while self._info is None:
            report = self._receive()
            if isinstance(report, BenchOpened):
                self._info = report.info
            elif isinstance(report, RunEnded) and report.error is not None:
                raise report.error
        return self._info

    def run(self, plan: Plan, expected: ExpectedModes | None = None) -> Generator[Event]:
        """Run a plan; yields its events as they come. It begins with the first; leaving early stops the run.

        Raises:
            ModallabError: what ended the run early, after its events.
            BenchError: the process died; what it acknowledged is kept.
        """
        _ = self.info
        if self._running:
            raise BenchError("a run is active", remedy="wait for its end, or stop it")
        self._begin(plan)
        try:
            self._send(RunPlan(plan, expected))
            yield from self._events()
        finally:
            self._running = False

    def stop(self) -> None:
        """End the active run; what it has recorded is valid."""
        self._send(StopRun())

    def abort(self) -> None:
        """End the active run; what it has recorded is kept and marked as invalid."""
        self._send(AbortRun())

    def emergency_stop(self, why: str = "by the operator") -> None:
        """Bring the output to 0 V past the rig's process where there is another way, trip the rig, abort the run.

        From any thread, in any state, with or without a run. Nothing is armed any more, by this process or a later one,
        until the latch is reset. It is not a safety-rated stop.

        Raises:
            BenchError: the supervisor or the process could not be reached; the rig is tripped all the same.
            StorageError: the trip could not be written; the output is at 0 V all the same.
        """
        try:
            if self.supervisor is not None:
                self.supervisor.zero_output()
        finally:
            try:
                self.latch.trip("emergency stop", why)
            finally:
                self._send(EmergencyStopOrder())

    @property
    def trip(self) -> Trip | None:
        """What has tripped the rig: an emergency stop, its process' death or time-out while it drove; None if not."""
        return self.latch.read()

    def request_exit(self) -> None:
        """Have the process end the active run as interrupted, bring the output to zero, and leave. Waits for nothing:
        whoever follows the run reads its end, then calls `close`."""
        with suppress(BenchError):
            self._send(CloseOrder())

    def close(self) -> None:
        """End the active run as interrupted, bring the output to zero, release the bench, end the process."""
        if self._closed.is_set():
            return
        self.request_exit()
        self._closed.set()
        # What is still in the pipe must be taken out, or the process could not leave for want of room in it.
        with suppress(BenchError):
            while self.process.is_alive():
                self._receive(LEAVE_S)
        self.process.join(LEAVE_S)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()
        if self.supervisor is not None:
            self.supervisor.close()
        self._connection.close()
        _OPEN.discard(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _events(self) -> Generator[Event]:
        finished = False
        try:
            while True:
                report = self._receive()
                if isinstance(report, RunEnded):
                    finished = True
                    if report.error is not None:
                        raise report.error
                    return
                if not isinstance(report, BenchOpened):
                    self._saw(report)
                    yield report
        except BenchError:
            finished = True
            raise
        finally:
            if not finished:
                self._drain()

    def _drain(self) -> None:
        with suppress(BenchError):
            self.stop()
            while not isinstance(self._receive(), RunEnded):
                pass

    def _receive(self, patience_s: float = float("inf")) -> Report:
        waited = 0.0
        try:
            # In short waits, since on Windows Ctrl-C does not interrupt a long one.
            while not self._connection.poll(POLL_S):
                waited += POLL_S
                if waited > patience_s:
                    raise BenchError(f"the acquisition process gave no sign of life for {patience_s:g} s")
            return self._connection.recv()
        except (EOFError, OSError) as error:
            raise self._died() from error

    def _died(self) -> BenchError:
        output = "" if self._closed.is_set() else zero_output_of_dead_process(self._url, self._rig)
        if output and self._driving:
            with suppress(ModallabError):
                self.latch.trip("death", "the acquisition process died while it drove")
        self.process.join(LEAVE_S)
        if not self._closed.is_set():
            with Store(self._folder) as store:
                store.recover()
        return BenchError(
            f"the acquisition process ended (exit code {self.process.exitcode}){output}",
            remedy="start the process again; every acknowledged block is kept, and the run is marked as interrupted",
        )

    def _send(self, message: Message) -> None:
        try:
            with self._sending:
                self._connection.send(message)
        except OSError as error:
            raise self._died() from error

    def _beat(self) -> None:
        while not self._closed.wait(HEARTBEAT_S):
            try:
                with self._sending:
                    self._connection.send(OwnerHeartbeat())
            except OSError:
                return


@atexit.register
def _close_all() -> None:
    # Registered after multiprocessing's own, so called before it: that one waits for every child.
    for process in list(_OPEN):
        process.close()
