"""A run of a rig: requested, then going on, with its events put into the log as they come, and commanded."""

import logging
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYetError
from contextlib import suppress
from threading import Lock

from modallab.acquisition.procedures.struck_point.participation import ExpectedModes
from modallab.acquisition.process.rig_process import RigProcess
from modallab.core.documents.runs import AcceptHit, Command, DropHit, RepeatFrequency
from modallab.core.errors import ModallabError, StorageError
from modallab.core.events import Event, RunFailed, RunState, StateChanged
from modallab.core.plan import ImpactPlan, Plan
from modallab.service.errors import NotFoundError, RigUnavailableError
from modallab.service.records import audit
from modallab.service.records.event_log import EventTopic
from modallab.service.records.repository import RunEntry, key_of_another
from modallab.service.rigs.control import StartRun, require_action
from modallab.service.rigs.run_log import RunLog
from modallab.storage.records import ENDED


class RequestedRun:
    """An order, and whose it is. Nobody would know of a run that begins after its asker heard that it did not."""

    def __init__(self, order: StartRun, operator: str) -> None:
        self.order = order
        self.operator = operator
        self.begun: Future[str] = Future()
        self.again = False
        """Whether the rig's process ended before it could begin, so that this is the second try."""
        self._lock = Lock()
        self._on_its_way = self._given_up = False

    def wait_for_name(self, patience_s: float) -> str:
        """The run's name, once it has begun.

        Raises:
            RigUnavailableError: it has not; if it is not being tried just now it will not be.
            ModallabError: what kept it from beginning.
        """
        try:
            return self.begun.result(patience_s)
        except NotYetError as error:
            with self._lock:
                self._given_up = not self._on_its_way
            raise RigUnavailableError(
                f"the run had not started after {patience_s:g} s",
                where=self.order.rig,
                remedy="try again when the rig is idle" if self._given_up else "read the campaign's list of runs",
            ) from error

    def is_of(self, order: StartRun) -> bool:
        """Whether `order` is the same request, sent again while this one may still begin.

        Raises:
            IdempotencyError: another request under the same key.
        """
        mine, other = self.order.key, order.key
        if mine is None or other is None or mine.key != other.key:
            return False
        with self._lock:
            if self._given_up or self.begun.done():
                return False
        if mine.request != other.request:
            raise key_of_another()
        return True

    def claim(self) -> bool:
        """Whether it is still requested; it is on its way then."""
        with self._lock:
            self._on_its_way = not self._given_up
            return self._on_its_way

    def return_to_queue(self) -> None:
        """It could not be tried, and will be once more."""
        with self._lock:
            self._on_its_way, self.again = False, True

    def reject(self, error: ModallabError) -> None:
        """It cannot begin."""
        self.begun.set_exception(error)


LOG = logging.getLogger(__name__)


class ActiveRun:
    """One run from its first event to its last."""

    def __init__(self, rig: str, order: StartRun, operator: str, run_log: RunLog) -> None:
        self.plan: Plan = order.plan
        self.run = ""
        self.state: RunState = "created"
        self.operator = operator
        self.run_log = run_log
        self._rig = rig
        self._order = order

    @property
    def topic(self) -> EventTopic:
        """What its events are about."""
        return EventTopic(self._rig, self._order.campaign, self.run)

    def run_to_end(self, process: RigProcess, begun: "Future[str]") -> ModallabError | None:
        """Run the plan to its end. `begun` gets the run's name; what kept it from beginning is returned, not raised."""
        with self.run_log.ends.following(self):
            return self._follow(process, begun)

    def command(self, process: RigProcess, command: Command, operator: str) -> None:
        """Pass a command on, and keep who gave it.

        Raises:
            IllegalTransitionError: the run's state has no step for it.
            PlanError: a frequency or level the plan does not have.
            NotFoundError: a block the run does not have.
        """
        require_action(self.state, command.kind)
        simple = {"pause": process.pause, "resume": process.resume, "stop": process.stop, "abort": process.abort}
        if isinstance(command, RepeatFrequency):
            process.repeat(command.frequency_hz, command.level or "")
        elif isinstance(command, DropHit):
            process.drop(self._block_name(command.n), command.reason)
        elif isinstance(command, AcceptHit):
            process.accept(self._block_name(command.n), command.reason, operator)
        else:
            simple[command.kind]()
        audit.enter_action(self.run_log.engine, operator, command.kind, self.run, command.model_dump(mode="json"))

    def _block_name(self, n: int) -> str:
        for block in self.run_log.store.catalogue.blocks(self.run):
            if block.n == n:
                return block.note.name
        raise NotFoundError(f"run {self.run} has no block {n}", where="n", remedy="read the list of its blocks")

    def _follow(self, process: RigProcess, begun: "Future[str]") -> ModallabError | None:
        try:
            events = process.run(self.plan, self._expected(process))
            try:
                self._begin(next(events))
                begun.set_result(self.run)
                for event in events:
                    self._note(event)
            finally:
                events.close()
        except StopIteration:
            return ModallabError("the rig's process started no run", remedy="look at the log")
        except ModallabError as error:
            self._ended_by(error)
            return None if begun.done() else error
        return None

    def _expected(self, process: RigProcess) -> ExpectedModes | None:
        if not isinstance(self.plan, ImpactPlan) or not self.plan.acceptance.check_point:
            return None
        # Here and not above: a service that runs no impact test starts without what it takes.
        from modallab.pipelines.known_modes import expected_modes

        return expected_modes(process.rig)

    def _begin(self, first: Event) -> None:
        self.run = first.run
        order = self._order
        entry = RunEntry(self.run, order.campaign, self._rig, self.operator, order.continues)
        self.run_log.repository.add_run(entry, order.plan.model_dump(mode="json"), order.key)
        self._note(first)

    def _note(self, event: Event) -> None:
        if isinstance(event, StateChanged):
            self.state = event.state
            if event.state in ENDED:
                self.run_log.ends.must_report(self.run)
        self.run_log.log.append(event.kind, self.topic, event.model_dump(mode="json"))
        if isinstance(event, RunFailed):
            self._keep_code(event.code)

    def _ended_by(self, error: ModallabError) -> None:
        # A process that was killed reported nothing of its run's end; its owner has marked it since.
        if not self.run or self.state in ENDED:
            return
        reason = error.what
        with suppress(ModallabError):
            reason = self.run_log.store.catalogue.run(self.run).reason or reason
        self._note(StateChanged(run=self.run, state="failed", reason=reason))
        self._note(RunFailed(run=self.run, code=error.code, what=error.what, remedy=error.remedy))

    def _keep_code(self, code: str) -> None:
        try:
            self.run_log.repository.set_code(self.run, code)
        except StorageError as error:
            LOG.warning("run %s: the code %s could not be kept: %s", self.run, code, error)
