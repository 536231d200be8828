"""A session at the bench from one program: as in the service, but in this process."""

import getpass
import secrets
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Self

from modallab.core.block import Campaign
from modallab.core.child_process import FileLock
from modallab.core.documents.pages import EventView
from modallab.core.documents.runs import CampaignRequest, Command, RunRequest
from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, Plan
from modallab.core.rig import Rig
from modallab.core.setups import SensorMove, require_setups, rig_in_set_up, sensor_moves, split_setups
from modallab.pipelines.known_modes import with_known_modes
from modallab.service.campaigns.run_start import begin_run
from modallab.service.context import open_service
from modallab.service.errors import RigUnavailableError, RunEndedError, ServiceError
from modallab.service.records.event_log import EventLog
from modallab.service.records.leases import RigLeases
from modallab.service.rigs.controller import RigController, ServedRig
from modallab.service.rigs.controllers import RigControllers, rig_ids
from modallab.service.rigs.run_log import RunLog, RunRecovery
from modallab.storage import Store, campaign_of
from modallab.storage.campaigns import campaigns_by_rig

Moved = Callable[[str, Sequence[SensorMove]], bool]
"""Has sensors moved: gets the set-up's name and what to move, returns once that is done; False to end the session."""

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
        PlanError: a plan has set-ups: see `record_setups`.
        ModallabError: what ended a run early; the output is at zero and all acknowledged blocks are in the folder.
    """
    with LocalCampaign(rig, url, folder, rig.name, local_user()) as session:
        return session.recorded(session.run_all(plans, notify))


def record_setups(
    url: str, rig: Rig, plans: Sequence[Plan], folder: Path, notify: Callable[[EventView], None], moved: Moved
) -> tuple[Campaign, ...]:
    """As `record_campaign`, of plans with set-ups: what was recorded in each, with the rig as it stood then.

    Args:
        url, rig, plans, folder, notify: as `record_campaign`.
        moved: has sensors moved, and returns once they stand where they belong.
    """
    with LocalCampaign(rig, url, folder, rig.name, local_user()) as session:
        return session.recorded_by_rig(session.run_all(plans, notify, moved=moved))


def local_user() -> str:
    """Who is logged in on this computer."""
    return getpass.getuser()


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
        self._lock = FileLock(folder / LOCK)
        if not self._lock.acquire():
            self._store.close()
            raise ServiceError(
                "a service uses this data folder", where=str(folder), remedy="use the service, or name another folder"
            )
        self._ended: SimpleQueue[str] = SimpleQueue()
        run_log = self._run_log = RunLog(self._store, EventLog(self._store.catalogue.engine))
        RunRecovery(run_log).check_now()
        (self._rig,) = rig_ids([rig.name])
        leases = RigLeases(self._store.catalogue.engine, boot)
        self._as_filed = rig
        self._controller = RigController(ServedRig(self._rig, rig, url, folder), run_log, self._ended.put)
        self._controllers = RigControllers([self._controller], leases)
        self._service = open_service(folder, self._controllers, boot)
        self._lease = self._service.leases.take(self._rig, operator, LEASE_S)
        self.campaign = self._service.repository.create(CampaignRequest(name=name, rig=self._rig), operator)

    @property
    def rig(self) -> Rig:
        """The rig as it was filed when the session began."""
        return self._as_filed

    def run_all(
        self,
        plans: Sequence[Plan],
        notify: Callable[[EventView], None],
        ended: Callable[[], bool] = lambda: False,
        moved: Moved | None = None,
    ) -> tuple[str, ...]:
        """Run plans in turn, each as `run`; returns the runs' names.

        A sine test that lengthens its bursts until they have settled, and names no modes, takes those of the impact
        test before it. Once `ended` says so, the plans that are left are not begun.

        An impact plan with set-ups is run once in each, on the rig as it then stands; before that `moved` is called
        with the sensors that stand elsewhere. A plan after it finds them where the rig file has them.

        Raises:
            PlanError: sensors are to be moved, but there is no `moved`; or set-ups that the rig cannot have.
            ModallabError: as `run`; the plans after it are not begun.
        """
        parts = self._parts(plans, moved)
        runs: list[str] = []
        for plan, rig in parts:
            if ended() or not self._stands(plan, rig, moved):
                break
            runs.append(self.run(with_known_modes(plan, partial(self._before, rig, runs)), notify))
        return tuple(runs)

    def recorded_by_rig(self, runs: Sequence[str]) -> tuple[Campaign, ...]:
        """What runs have recorded, a campaign for each place the sensors stood in, in the order of time.

        Raises:
            StorageError, DataError: it cannot be read.
        """
        return campaigns_by_rig(self._store, runs)

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
        seen = self._service.log.newest_number()
        run = begin_run(self._service, self.campaign.id, RunRequest(plan=plan), self._lease.id)
        ended, remedy = False, ""
        while True:
            events = self._service.log.events_after(seen, 1000)
            for event in (event for event in events if event.run == run):
                remedy = event.content["remedy"] if event.kind == "failed" else remedy
                notify(event)
            seen = events[-1].seq if events else seen
            if ended and not events:
                return self._require_done(run, remedy)
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
        self._run_log.close()
        self._service.close()
        self._lock.release()
        self._store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _parts(self, plans: Sequence[Plan], moved: Moved | None) -> list[tuple[Plan, Rig]]:
        """Every plan with the rig it is run on, one for each set-up."""
        parts: list[tuple[Plan, Rig]] = []
        for plan in plans:
            if not isinstance(plan, ImpactPlan) or not plan.setups:
                parts.append((plan, self._as_filed))
                continue
            require_setups(plan, self._as_filed)
            if moved is None:
                raise PlanError(
                    f"{len(plan.setups)} setups, and no operator to move sensors",
                    where="impact plan",
                    remedy="use record_setups, or modallab campaign run",
                )
            parts += [(part, rig_in_set_up(self._as_filed, part.setups[0])) for part in split_setups(plan)]
        return parts

    def _stands(self, plan: Plan, rig: Rig, moved: Moved | None) -> bool:
        """Have the sensors stand as in `rig`; False if the session is ended instead."""
        bench = self._controller.bench
        to_move = sensor_moves(bench.rig, rig)
        if not to_move:
            return True
        name = plan.setups[0].name if isinstance(plan, ImpactPlan) and plan.setups else "as in the rig file"
        self._wait_until_open()
        if moved is None or not moved(name, to_move):
            return False
        self._controller.close()
        self._controller = RigController(replace(bench, rig=rig), self._run_log, self._ended.put)
        self._controllers.replace(self._controller)
        return True

    def _before(self, rig: Rig, runs: Sequence[str]) -> Campaign:
        """What was recorded on this rig, or else where the sensors stood last: modes differ little."""
        rigs = [self._store.catalogue.run(run).rig for run in runs]
        wanted = rig if rig in rigs or not rigs else rigs[-1]
        return self.recorded([run for run, on in zip(runs, rigs, strict=True) if on == wanted])

    def _has_ended(self) -> bool:
        try:
            self._ended.get(timeout=LOOK_S)
        except Empty:
            return False
        return True

    def _wait_until_open(self) -> None:
        state = self._controller.wait_until_settled(OPEN_S)
        if state.state != "idle":
            raise RigUnavailableError.of(f"the bench is {state.state}", state.error, state.bench)

    def _require_done(self, run: str, remedy: str) -> str:
        record = self._store.catalogue.run(run)
        if record.state != "done":
            raise RunEndedError(
                f"the run is {record.state}: {record.reason}",
                where=run,
                remedy=remedy or "its stored blocks can be read",
            )
        return run
