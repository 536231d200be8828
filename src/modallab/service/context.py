"""All that the service knows, in one place, for whoever answers questions about it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Engine

from modallab.jobs import Job, Jobs
from modallab.service.records import audit
from modallab.service.records.event_log import EventLog
from modallab.service.records.leases import RigLeases
from modallab.service.records.repository import CampaignRepository
from modallab.service.rigs.control import RigControl
from modallab.storage import Store

if TYPE_CHECKING:
    from modallab.service.campaigns.live_frf import LiveFrfs


@dataclass(frozen=True, eq=False, slots=True)
class Service:
    """One data folder, and the rigs that record into it.

    Attributes:
        store: runs and blocks.
        control: commands to the rigs.
        boot: names this start of the service; leases of another are void.
        log: events.
        repository: campaigns.
        leases: who may command which rig.
        jobs: identification, diagnosis, reports.
        frfs: FRFs of runs as far as they have come.
    """

    store: Store
    control: RigControl
    boot: str
    log: EventLog
    repository: CampaignRepository
    leases: RigLeases
    jobs: Jobs
    frfs: Callable[[], "LiveFrfs"]

    @property
    def engine(self) -> Engine:
        """The database."""
        return self.store.catalogue.engine

    @property
    def folder(self) -> Path:
        """The data folder."""
        return self.store.folder

    def cancel(self, job: str, operator: str) -> Job:
        """Cancel a job, and keep who did.

        Raises:
            UnknownJobError: there is none of this name.
        """
        cancelled = self.jobs.cancel(job)
        audit.enter_action(self.engine, operator, "cancel-job", job, {"state": cancelled.state})
        return cancelled

    def close(self) -> None:
        """Let go of the database."""
        self.store.close()


def open_service(folder: Path, control: RigControl, boot: str) -> Service:
    """Open a data folder for the service.

    Raises:
        StorageError, FormatError: it cannot be used.
    """
    store = Store(folder)
    engine = store.catalogue.engine
    return Service(
        store=store,
        control=control,
        boot=boot,
        log=EventLog(engine),
        repository=CampaignRepository(engine),
        leases=RigLeases(engine, boot),
        jobs=Jobs(engine),
        frfs=_frfs(store),
    )


def _frfs(store: Store) -> "Callable[[], LiveFrfs]":
    @cache
    def made() -> "LiveFrfs":
        # Imported when first asked for: it takes seconds, and the service can be asked everything else meanwhile.
        from modallab.service.campaigns.live_frf import LiveFrfs

        return LiveFrfs(store)

    return made
