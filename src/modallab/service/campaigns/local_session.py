"""A session at the bench from one program: as in the service, but in this process."""

import getpass
import secrets
from collections.abc import Callable, Sequence
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Self

from modallab.core.block import Campaign
from modallab.core.documents.campaigns import CampaignNew
from modallab.core.documents.pages import EventView
from modallab.core.documents.runs import Command, RunNew
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.pipelines.known_modes import with_known_modes
from modallab.service.campaigns.begin import begin
from modallab.service.context import open_service
from modallab.service.errors import RigUnavailableError, RunEndedError, ServiceError
from modallab.service.records.event_log import EventLog
from modallab.service.records.leases import Leases
from modallab.service.rigs.controller import Bench, Controller
from modallab.service.rigs.controllers import Controllers, rig_ids
from modallab.service.rigs.diary import Diary, Recovery
from modallab.storage import Store, campaign_of
from modallab.storage.lease import Lease

LOCK = "service.lock"
LOOK_S = 0.05
OPEN_S = 300.0
LEASE_S = 3600.0


def record_campaign(
    url: str, rig: Rig, plans: Sequence[Plan], folder: Path, notify: Callable[[EventView], None]
) -> Campaign:
    """Run `plans` in turn on the bench at `url`, in its own process, and read back what was recorded.

    Args:
        url: address of the bench.
        rig: what stands on it.
        plans: what to do, in this order, as `LocalCampaign.run_all`.
        folder: where the recordings are kept.
        notify: called with every event, as it comes.

    Raises:
        ModallabError: what ended a run early; the output is at zero and all acknowledged blocks are in the folder.
    """
    with LocalCampaign(rig, url, folder, rig.name, getpass.getuser()) as session:
        return session.recorded(session.run_all(plans, notify))


class LocalCampaign:
    """One rig and one campaign on it. As a context manager it leaves the bench at rest."""

    def __init__(self, rig: Rig, url: str, folder: Path, name: str, operator: str) -> None:
        """Open the folder and begin to open the bench.

        Raises:
            ServiceError: a service uses the folder.
            StorageError: the folder cannot be used.
        """
        boot = secrets.token_hex(8)
        self._store = Store(folder)
        self._lock = Lease(folder / LOCK)
        if not self._lock.acquire():
            self._store.close()
            raise ServiceError(
                "a service uses this data folder", where=str(folder), remedy="ask the service, or name another folder"
            )
        self._ended: SimpleQueue[str] = SimpleQueue()
        diary = self._diary = Diary(self._store, EventLog(self._store.catalogue.engine))
        Recovery(diary).look()
        (self._rig,) = rig_ids([rig.name])
        leases = Leases(self._store.catalogue.engine, boot)
        self._controller = Controller(Bench(self._rig, rig, url, folder), diary, self._ended.put)
        self._controllers = Controllers([self._controller], leases)
        self._service = open_service(folder, self._controllers, boot)
        self._lease = self._service.leases.take(self._rig, operator, LEASE_S)
        self.campaign = self._service.repository.create(CampaignNew(name=name, rig=self._rig), operator)

    def run_all(
        self, plans: Sequence[Plan], notify: Callable[[EventView], None], ended: Callable[[], bool] = lambda: False
    ) -> tuple[str, ...]:
        """Run plans in turn, each as `run`; returns the runs' names.

        A sine test that lengthens its bursts until they have settled, and names no modes, takes those of the impact
        test before it. Once `ended` says so, the plans that are left are not begun.

        Raises:
            ModallabError: as `run`; the plans after it are not begun.
        """
        runs: list[str] = []
        for plan in plans:
            if ended():
                break
            runs.append(self.run(with_known_modes(plan, lambda: self.recorded(runs)), notify))
        return tuple(runs)

    def recorded(self, runs: Sequence[str]) -> Campaign:
        """What runs have recorded, read back from the disk.

        Raises:
            StorageError, DataError: it cannot be read, or does not belong together.
        """
        return campaign_of(self._store, runs)

    def run(self, plan: Plan, notify: Callable[[EventView], None]) -> str:
        """Run a plan to its end; `notify` gets every event of it. Returns the run's name.

        Raises:
            ModallabError: it could not be begun, or ended early; what was acknowledged is kept.
        """
        self._wait_until_open()
        self._service.leases.renew(self._rig, self._lease.id)
        seen = self._service.log.last()
        run = begin(self._service, self.campaign.id, RunNew(plan=plan), self._lease.id)
        ended = False
        while True:
            events = self._service.log.after(seen, 1000)
            for event in (event for event in events if event.run == run):
                notify(event)
            seen = events[-1].seq if events else seen
            if ended and not events:
                return self._require_done(run)
            ended = ended or self._has_ended()

    def command(self, run: str, command: Command) -> None:
        """Pass a command on to the active run. Raises as `Control`."""
        self._controllers.command(self._rig, run, command, self._lease.id)

    def emergency_stop(self, reason: str) -> None:
        """Bring the output to 0 V and latch the rig. Raises as `Control`."""
        self._controllers.emergency_stop(None, reason, self._lease.operator)

    def close(self) -> None:
        """Leave the bench at rest."""
        self._controllers.close()
        self._service.leases.release(self._rig, self._lease.id)
        self._diary.close()
        self._service.close()
        self._lock.release()
        self._store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _has_ended(self) -> bool:
        try:
            self._ended.get(timeout=LOOK_S)
        except Empty:
            return False
        return True

    def _wait_until_open(self) -> None:
        state = self._controller.wait_until_settled(OPEN_S)
        if state.state != "idle":
            raise RigUnavailableError(
                f"the bench is {state.state}: {state.error}", where=state.bench, remedy="look at its cables and address"
            )

    def _require_done(self, run: str) -> str:
        record = self._store.catalogue.run(run)
        if record.state != "done":
            raise RunEndedError(
                f"the run is {record.state}: {record.reason}", where=run, remedy="what it had kept can be read"
            )
        return run
