"""Begins queued runs, one after the other: the next when the one before has ended well."""

import logging
from collections.abc import Callable
from threading import Event as Flag
from threading import Thread

from modallab.acquisition.process.trip import Trip, TrippedError
from modallab.core.documents.messages import QueueChanged
from modallab.core.documents.queue import ConsentView, QueueItem, QueueState
from modallab.core.errors import ModallabError
from modallab.service.errors import ConflictError, LeaseNeededError, RigUnavailableError
from modallab.service.records.event_log import EventTopic
from modallab.service.records.repository import RunKey
from modallab.service.records.run_queue import RunQueue
from modallab.service.rigs.control import Consent, ControllerState, StartRun
from modallab.service.rigs.controllers import RigControllers
from modallab.service.rigs.run_log import RunLog
from modallab.storage.records import ENDED


def reason_not_to_begin(item: QueueItem, state: ControllerState, trip: Trip | None, consent: ConsentView | None) -> str:
    """Why an item cannot begin now; "" if it can.

    A shaker never starts by itself unless who holds the lease has consented to this very item, and an impact test waits
    until he says that he is at the bench.
    """
    if trip is not None:
        return f"the rig is tripped: {trip.what}; check the bench, then reset the rig"
    if state.state != "idle":
        return f"run {state.run} is on" if state.run else f"the rig is {state.state}"
    if consent is None:
        return f"no holder of the lease has consented to this run{_unless_consented(item)}"
    if item.id not in consent.items:
        return f"{consent.operator}'s consent was given before this run was queued{_unless_consented(item)}"
    if item.drives and not consent.drive:
        return f"{consent.operator} has not consented to tests that move the output"
    if not item.drives and not consent.at_bench:
        return f"{consent.operator} has not confirmed to be at the bench, as this test needs"
    return ""


def _unless_consented(item: QueueItem) -> str:
    need = "tests that drive" if item.drives else "impact tests, at the bench"
    return f"; consent to {need}, with the lease"


LOG = logging.getLogger(__name__)
LOOK_S = 0.3
QUEUE = "the queue"


class QueueRunner:
    """Looks at the queues of all rigs on a thread of its own; what it knows is in the database, but for consents."""

    def __init__(
        self, controllers: RigControllers, run_log: RunLog, may_begin: Callable[[], bool] = lambda: True
    ) -> None:
        """Begin to look.

        Args:
            controllers: the rigs.
            run_log: where it writes.
            may_begin: whether anybody could see and command a run that begins now.
        """
        self._controllers = controllers
        self._run_log = run_log
        self._queue = RunQueue(run_log.engine)
        self._may_begin = may_begin
        self._closing = Flag()
        self._thread = Thread(target=self._work, name="queue", daemon=True)
        self._thread.start()

    def request_close(self) -> None:
        """Begin nothing more; waits for nothing."""
        self._closing.set()

    def close(self) -> None:
        """As `request_close`, and wait until it has happened."""
        self._closing.set()
        self._thread.join()

    def check_now(self) -> None:
        """Look once.

        Raises:
            StorageError: the database does not answer; the next look tries again.
        """
        items = self._queue.open()
        for rig in self._controllers.consents.take_stopped():
            if any(item.rig == rig for item in items):
                self._pause(rig, "the rig had an emergency stop")
        paused = self._queue.paused()
        for state in self._controllers.states():
            first = next((item for item in items if item.rig == state.id), None)
            if first is None:
                continue
            if first.state == "running":
                self._follow(first, state)
            elif state.id not in paused and not self._closing.is_set():
                self._try(first, state)

    def _work(self) -> None:
        while not self._closing.wait(LOOK_S):
            try:
                self.check_now()
            except ModallabError as error:
                LOG.warning("queue: %s", error)
            except Exception:
                LOG.exception("queue")

    def _try(self, item: QueueItem, state: ControllerState) -> None:
        consent = self._controllers.consent(item.rig)
        if consent is not None and consent.process != self._controllers.pid(item.rig):
            self._pause(item.rig, "the rig's process was restarted after the consent")
            return
        given = None if consent is None else consent.view
        if reason_not_to_begin(item, state, self._controllers.trip(item.rig), given) or not self._may_begin():
            return
        if consent is not None and self._queue.claim(item.id):
            self._begin(item, consent)

    def _begin(self, item: QueueItem, consent: Consent) -> None:
        order = StartRun(item.rig, item.campaign, item.plan, consent.lease, key=_key_of_item(item))
        try:
            run = self._controllers.start_queued(order)
        except (LeaseNeededError, ConflictError, TrippedError):
            # The lease is over by now, somebody has begun another run meanwhile, or has stopped the rig.
            self._set(item, "waiting")
        except RigUnavailableError as error:
            # It may begin yet: whether it has is looked up.
            self._pause(item.rig, f"item {item.id}: {error.what}")
        except ModallabError as error:
            self._fail(item, str(error), f"item {item.id} could not start: {error.what}")
        else:
            self._set(item, "running", run=run)

    def _follow(self, item: QueueItem, state: ControllerState) -> None:
        if not item.run:
            self._find(item, state)
            return
        record = self._run_log.store.catalogue.run(item.run)
        if record.state not in ENDED:
            return
        if record.state == "done" and not record.reason:
            self._set(item, "done", run=item.run)
            return
        reason = f"run {item.run} is {record.state}: {record.reason or 'see its events'}"
        self._fail(item, reason, reason, run=item.run)

    def _find(self, item: QueueItem, state: ControllerState) -> None:
        # Its beginning was not heard of: this service, or the one before, was ended or kept waiting in between.
        run = self._run_log.repository.run_of(_key_of_item(item))
        if run is not None:
            self._set(item, "running", run=run)
        elif state.state == "idle":
            self._set(item, "waiting")

    def _set(self, item: QueueItem, state: QueueState, *, run: str = "", reason: str = "") -> None:
        self._queue.set_state(item.id, state, run=run, reason=reason)
        self._notify(item.rig, item=item.id, state=state, run=run, reason=reason)

    def _fail(self, item: QueueItem, why: str, pause: str, run: str = "") -> None:
        # Paused first: at no moment may the next one seem free to begin.
        self._pause(item.rig, pause)
        self._set(item, "failed", run=run, reason=why)

    def _pause(self, rig: str, reason: str) -> None:
        self._controllers.consents.withdraw(rig)
        self._queue.pause(rig, reason, QUEUE)
        self._notify(rig, state="paused", reason=reason)

    def _notify(self, rig: str, **content: str) -> None:
        said = QueueChanged.model_validate({"rig": rig} | content)
        self._run_log.log.append(said.kind, EventTopic(rig=rig), said.content())


def _key_of_item(item: QueueItem) -> RunKey:
    # No request can carry a key with a blank in it.
    return RunKey(f"queue {item.id}", item.id)
