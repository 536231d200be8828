"""A run that is going on: it enters the repository first, then its events go into the log as they come."""

import logging
from concurrent.futures import Future
from contextlib import suppress

from sqlalchemy import Engine

from modallab.acquisition.process.rig_process import RigProcess
from modallab.core.errors import ModallabError, StorageError
from modallab.core.events import Event, Failed, RunState, StateChanged
from modallab.core.plan import Plan
from modallab.service.records import audit
from modallab.service.records.event_log import EventLog, Topic
from modallab.service.records.repository import CampaignRepository, RunEntry
from modallab.service.rigs.control import StartRun
from modallab.service.rigs.run_end import Ends
from modallab.storage import Store
from modallab.storage.records import ENDED

LOG = logging.getLogger(__name__)


class Diary:
    """Where a controller writes: the repository, the log of events, and who did what."""

    def __init__(self, store: Store, log: EventLog) -> None:
        self.store = store
        self.log = log
        self.engine: Engine = store.catalogue.engine
        self.repository = CampaignRepository(self.engine)
        self.ends = Ends()

    def rig_state(self, rig: str, state: str, error: str) -> None:
        """The rig's process is in another state."""
        self.log.append("rig", Topic(rig=rig), {"kind": "rig", "rig": rig, "state": state, "error": error})

    def tripped(self, rig: str, reason: str, operator: str) -> None:
        """Someone or something stopped the rig; a full disk does not undo that."""
        content = {"kind": "tripped", "rig": rig, "reason": reason, "operator": operator}
        self.log.append("tripped", Topic(rig=rig), content)
        self._enter(operator, "emergency-stop", rig, reason)

    def reset(self, rig: str, reason: str, operator: str) -> None:
        """Someone has reset it."""
        content = {"kind": "reset", "rig": rig, "reason": reason, "operator": operator}
        self.log.append("reset", Topic(rig=rig), content)
        self._enter(operator, "reset", rig, reason)

    def _enter(self, operator: str, action: str, rig: str, reason: str) -> None:
        try:
            audit.enter(self.engine, operator, action, rig, {"reason": reason})
        except StorageError as error:
            LOG.warning("%s of %s by %s could not be kept: %s", action, rig, operator, error)


class ActiveRun:
    """One run from its first event to its last."""

    def __init__(self, rig: str, order: StartRun, operator: str, diary: Diary) -> None:
        self.plan: Plan = order.plan
        self.run = ""
        self.state: RunState = "created"
        self.operator = operator
        self.diary = diary
        self._rig = rig
        self._order = order

    @property
    def topic(self) -> Topic:
        """What its events are about."""
        return Topic(self._rig, self._order.campaign, self.run)

    def follow(self, process: RigProcess, begun: "Future[str]") -> ModallabError | None:
        """Run the plan to its end. `begun` gets the run's name; what kept it from beginning is returned, not raised."""
        with self.diary.ends.following(self):
            return self._follow(process, begun)

    def _follow(self, process: RigProcess, begun: "Future[str]") -> ModallabError | None:
        try:
            events = process.run(self.plan)
            try:
                self._begin(next(events))
                begun.set_result(self.run)
                for event in events:
                    self._note(event)
            finally:
                events.close()
        except StopIteration:
            return ModallabError("the rig's process began no run", remedy="look at the log")
        except ModallabError as error:
            self._ended_by(error)
            return None if begun.done() else error
        return None

    def _begin(self, first: Event) -> None:
        self.run = first.run
        order = self._order
        entry = RunEntry(self.run, order.campaign, self._rig, self.operator, order.continues)
        self.diary.repository.add_run(entry, order.plan.model_dump(mode="json"))
        self._note(first)

    def _note(self, event: Event) -> None:
        if isinstance(event, StateChanged):
            self.state = event.state
            if event.state in ENDED:
                self.diary.ends.notify(self.run)
        self.diary.log.append(event.kind, self.topic, event.model_dump(mode="json"))
        if isinstance(event, Failed):
            self._keep_code(event.code)

    def _ended_by(self, error: ModallabError) -> None:
        # A process that was killed reported to nobody how its run ended; its owner has marked it since.
        if not self.run or self.state in ENDED:
            return
        reason = error.what
        with suppress(ModallabError):
            reason = self.diary.store.catalogue.run(self.run).reason or reason
        self._note(StateChanged(run=self.run, state="failed", reason=reason))
        self._note(Failed(run=self.run, code=error.code, what=error.what, remedy=error.remedy))

    def _keep_code(self, code: str) -> None:
        try:
            self.diary.repository.set_code(self.run, code)
        except StorageError as error:
            LOG.warning("run %s: the code %s could not be kept: %s", self.run, code, error)
