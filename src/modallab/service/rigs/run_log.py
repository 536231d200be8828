"""Where a controller writes, and the end of every run: reported once, by whoever finds it out first."""

import logging
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from queue import SimpleQueue
from threading import Lock, Thread
from typing import Protocol

from sqlalchemy import Engine, func, select

from modallab.core.documents.messages import RigChanged, RigReset, RigTripped
from modallab.core.documents.rigs import RigState
from modallab.core.errors import StorageError
from modallab.core.events import StateChanged
from modallab.service.records import audit
from modallab.service.records.event_log import EventLog, EventTopic
from modallab.service.records.repository import CampaignRepository
from modallab.service.records.rig_revisions import RigRevisions
from modallab.storage import Store
from modallab.storage.engine import read_transaction
from modallab.storage.records import ENDED
from modallab.storage.service_tables import CAMPAIGN_RUNS, EVENTS

CODE = "interrupted"
LOOK_S = 2.0
CLOSE_S = 0.5


class FollowedRun(Protocol):
    """A run while a controller follows it."""

    run: str
    """Its name; "" until it has begun."""


class EndedRunNotifier:
    """Runs that are followed, and runs whose end was reported. From any thread."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._followed: list[FollowedRun] = []
        self._reported: set[str] = set()

    @contextmanager
    def following(self, active: FollowedRun) -> Generator[None]:
        """While this lasts, who follows the run reports its end, and nobody else."""
        with self._lock:
            self._followed.append(active)
        try:
            yield
        finally:
            with self._lock:
                self._followed.remove(active)

    def must_report(self, run: str) -> bool:
        """Whether this end is to be reported: nobody has."""
        with self._lock:
            new = run not in self._reported
            self._reported.add(run)
            return new

    def has_no_followers(self, run: str) -> bool:
        """Whether nobody follows the run, nor one that might yet turn out to be it."""
        with self._lock:
            return all(active.run not in ("", run) for active in self._followed)


LOG = logging.getLogger(__name__)


class RunLog:
    """Where a controller writes: the repository, the log of events, and who did what."""

    def __init__(self, store: Store, log: EventLog) -> None:
        self.store = store
        self.log = log
        self.engine: Engine = store.catalogue.engine
        self.repository = CampaignRepository(self.engine)
        self.revisions = RigRevisions(self.engine)
        self.ends = EndedRunNotifier()
        self._stops: SimpleQueue[tuple[str, str, str] | None] = SimpleQueue()
        self._writer = Thread(target=self._enter_stops, name="stops", daemon=True)
        self._writer.start()

    def close(self) -> None:
        """Write what still waits, if the database takes it soon."""
        self._stops.put(None)
        self._writer.join(CLOSE_S)

    def rig_state(self, rig: str, state: RigState, error: str) -> None:
        """The rig's process is in another state."""
        self.log.append("rig", EventTopic(rig=rig), RigChanged(rig=rig, state=state, error=error).model_dump())

    def tripped(self, rig: str, reason: str, operator: str) -> None:
        """Someone or something stopped the rig. Whoever stops waits neither for the disk nor for the database."""
        said = RigTripped(rig=rig, reason=reason, operator=operator)
        self.log.append_later(said.kind, EventTopic(rig=rig), said.model_dump())
        self._stops.put((operator, rig, reason))

    def reset(self, rig: str, reason: str, operator: str) -> None:
        """Someone has reset it."""
        said = RigReset(rig=rig, reason=reason, operator=operator)
        self.log.append(said.kind, EventTopic(rig=rig), said.model_dump())
        self._enter(operator, "reset", rig, reason)

    def _enter_stops(self) -> None:
        while (stop := self._stops.get()) is not None:
            operator, rig, reason = stop
            self.log.flush()
            self._enter(operator, "emergency-stop", rig, reason)

    def _enter(self, operator: str, action: str, rig: str, reason: str) -> None:
        try:
            audit.enter_action(self.engine, operator, action, rig, {"reason": reason})
        except StorageError as error:
            LOG.warning("%s of %s by %s could not be kept: %s", action, rig, operator, error)


class RunRecovery:
    """Looks now and then: a rig's process that outlived its service may die late, and a full disk may take no row."""

    def __init__(self, run_log: RunLog, ended: Callable[[str], None] | None = None, look_s: float = LOOK_S) -> None:
        """Begin with the runs whose end is not in the log of events.

        Args:
            run_log: where it writes.
            ended: called with the name of every run whose end is reported here.
            look_s: between two looks at least.

        Raises:
            StorageError: the log cannot be read.
        """
        self._run_log = run_log
        self._ended = ended
        self._look_s = look_s
        self._unreported = unreported_runs(run_log.engine)
        self._looked_s = float("-inf")

    def check_now(self) -> None:
        """Mark what is there to be marked, and report what is there to be reported.

        Raises:
            StorageError: it could not be kept; the next look tries again.
        """
        now = time.monotonic()
        if now - self._looked_s < self._look_s:
            return
        self._looked_s = now
        self._unreported |= set(self._run_log.store.recover())
        for run in sorted(self._unreported):
            # Who follows a run hears of its recorder's death at the same moment, and reports it.
            if self._run_log.ends.has_no_followers(run):
                self._notify(run)

    def _notify(self, run: str) -> None:
        record = self._run_log.store.catalogue.run(run)
        if record.state not in ENDED:
            return
        self._unreported.discard(run)
        if not self._run_log.ends.must_report(run):
            return
        entry = self._run_log.repository.run_entry(run)
        topic = EventTopic(run=run) if entry is None else EventTopic(entry.rig, entry.campaign, run)
        if record.state == "failed" and entry is not None and not entry.code:
            with suppress(StorageError):
                self._run_log.repository.set_code(run, CODE)
        said = StateChanged(run=run, state=record.state, reason=record.reason)
        self._run_log.log.append("state", topic, said.model_dump())
        if self._ended is not None:
            self._ended(run)


def unreported_runs(engine: Engine) -> set[str]:
    """Runs of the repository whose last state in the log of events is not their end.

    Raises:
        StorageError: the tables cannot be read.
    """
    of_a_run = select(func.max(EVENTS.c.seq)).where(EVENTS.c.kind == "state", EVENTS.c.run != "").group_by(EVENTS.c.run)
    query = select(EVENTS.c.run, EVENTS.c.content).where(EVENTS.c.seq.in_(of_a_run))
    with read_transaction(engine) as connection:
        reported = {row.run for row in connection.execute(query) if row.content["state"] in ENDED}
        return set(connection.scalars(select(CAMPAIGN_RUNS.c.run))) - reported
