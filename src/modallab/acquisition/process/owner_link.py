"""The pipe between a rig's process and its owner: what goes over it besides the events, and the process's own end."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Event as Flag
from threading import Thread

from modallab.acquisition.monitor.run_states import AcceptBlock, DropBlock, OperatorRequests
from modallab.acquisition.procedures.struck_point.participation import ExpectedModes
from modallab.acquisition.process.prepare_run import Order
from modallab.bench.protocol import BenchInfo
from modallab.core.documents.runs import AbortRun, PauseRun, RepeatFrequency, ResumeRun, StopRun
from modallab.core.errors import ModallabError
from modallab.core.events import Event
from modallab.core.plan import Plan

HEARTBEAT_S = 0.25
FLUSH_S = 5.0
TIMEOUT_S = 5.0
"""An owner that said nothing for so long is gone. A busy one was measured late by 1.3 s."""


@dataclass(frozen=True, slots=True)
class RunPlan:
    """Begin a run.

    Attributes:
        plan: plan of the run.
        expected: the modes the structure is believed to have; None if nothing is believed.
    """

    plan: Plan
    expected: ExpectedModes | None = None


@dataclass(frozen=True, slots=True)
class EmergencyStopOrder:
    """As abort; the rig is tripped already."""


@dataclass(frozen=True, slots=True)
class CloseOrder:
    """End the run if there is one, release the bench, and leave."""


@dataclass(frozen=True, slots=True)
class OwnerHeartbeat:
    """The owner lives."""


Message = (
    RunPlan
    | PauseRun
    | ResumeRun
    | RepeatFrequency
    | DropBlock
    | AcceptBlock
    | StopRun
    | AbortRun
    | EmergencyStopOrder
    | CloseOrder
    | OwnerHeartbeat
)
"""What the owner sends: an operator's commands as they are in the API, and what only the owner may ask for."""


@dataclass(frozen=True, slots=True)
class BenchOpened:
    """The bench is open, its output at zero."""

    info: BenchInfo


@dataclass(frozen=True, slots=True)
class RunEnded:
    """No run is active any more; `error` says why, if it is for an error."""

    error: ModallabError | None


Report = Event | BenchOpened | RunEnded


class OwnerLink:
    """Two threads on one connection: one hears commands and heartbeats, one sends reports.

    The acquisition only looks at `order` and only puts reports into a queue, so that neither a slow nor a stopped
    owner can hold it up while the beam is driven.
    """

    def __init__(self, connection: Connection, timeout_s: float = TIMEOUT_S) -> None:
        self._connection = connection
        self._timeout_s = timeout_s
        self._order: Order | None = None
        self.requests = OperatorRequests()
        self._plans: SimpleQueue[RunPlan | None] = SimpleQueue()
        self._asked = Flag()
        self._reports: SimpleQueue[Report | None] = SimpleQueue()
        self._sender = Thread(target=self._send_all, name="reports", daemon=True)
        self._sender.start()
        Thread(target=self._receive, name="commands", daemon=True).start()

    def next_order(self) -> Order | None:
        """What the owner wants of the active run."""
        return self._order

    def has_plan(self, patience_s: float) -> bool:
        """Whether there is something for `next_plan`, after a short wait for it."""
        return self._asked.wait(patience_s)

    def next_plan(self) -> RunPlan | None:
        """Wait for the next run; None when it is time to leave."""
        plan = self._plans.get()
        if self._plans.empty():
            self._asked.clear()
        return plan

    def send(self, report: Report) -> None:
        """Queue a report."""
        self._reports.put(report)

    def flush(self) -> None:
        """Send what is queued and no more after it."""
        self._reports.put(None)
        self._sender.join(FLUSH_S)

    def _send_all(self) -> None:
        while (report := self._reports.get()) is not None:
            try:
                self._connection.send(report)
            except OSError:
                self._lost()
                return

    def _receive(self) -> None:
        received_s = time.monotonic()
        while self._order != "lost":
            try:
                if self._connection.poll(HEARTBEAT_S):
                    self._obey(self._connection.recv())
                    received_s = time.monotonic()
                elif time.monotonic() - received_s > self._timeout_s:
                    self._lost()
            except (EOFError, OSError):
                self._lost()

    def _obey(self, command: Message) -> None:
        act: dict[type[Message], Callable[[], None]] = {
            OwnerHeartbeat: lambda: None,
            StopRun: lambda: self._request("stop"),
            AbortRun: lambda: self._request("abort"),
            EmergencyStopOrder: lambda: self._request("emergency"),
            PauseRun: self.requests.pause,
            ResumeRun: self.requests.resume,
            CloseOrder: self._leave,
        }
        if isinstance(command, RunPlan):
            # A stop that came too late for the run before is no stop of this one.
            self._order = None
            self.requests.clear()
            self._put(command)
        elif isinstance(command, RepeatFrequency | DropBlock | AcceptBlock):
            self.requests.add(command)
        else:
            act[type(command)]()

    def _request(self, order: Order) -> None:
        self._order = order

    def _leave(self) -> None:
        self._order = "ended"
        self._put(None)

    def _lost(self) -> None:
        self._order = "lost"
        self._put(None)

    def _put(self, plan: RunPlan | None) -> None:
        self._plans.put(plan)
        self._asked.set()
