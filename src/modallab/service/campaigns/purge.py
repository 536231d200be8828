"""Deletes the samples of what was deleted, when its grace time has ended."""

import logging
import time
from collections.abc import Callable, Iterable
from datetime import UTC, datetime, timedelta

from modallab.core.errors import ModallabError, UnknownJobError
from modallab.jobs import Jobs
from modallab.service.records.archive import ArchivedRecords, Kind
from modallab.service.records.repository import CampaignRepository
from modallab.storage import Store
from modallab.storage.campaigns import RemovableRun, remove_samples
from modallab.storage.records import ENDED

LOG = logging.getLogger(__name__)
LOOK_S = 60.0


def _utc_now() -> datetime:
    return datetime.now(UTC)


class PurgeTimer:
    """Looks now and then. A clock that is set forward while the service runs ends no grace time."""

    def __init__(
        self,
        store: Store,
        look_s: float = LOOK_S,
        wall: Callable[[], datetime] = _utc_now,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing is deleted yet; the first look is after `look_s`.

        Args:
            store: of the samples.
            look_s: between two looks at least.
            wall: the time of day.
            clock: monotonic, in seconds.
        """
        engine = store.catalogue.engine
        self._store = store
        self._aside = ArchivedRecords(engine)
        self._repository = CampaignRepository(engine)
        self._jobs = Jobs(engine)
        self._look_s = look_s
        self._wall, self._clock = wall, clock
        self._began = wall()
        self._began_s = self._looked_s = clock()

    def check_now(self) -> None:
        """Delete what is due, if it is time to look.

        Raises:
            StorageError: the database does not answer; the next look tries again.
        """
        if self._clock() - self._looked_s < self._look_s:
            return
        self._looked_s = self._clock()
        passed = timedelta(seconds=self._clock() - self._began_s)
        now = min(self._wall(), self._began + passed).isoformat(timespec="milliseconds")
        for kind, name in self._aside.expired_entries(now):
            try:
                if self._aside.begin_purge(kind, name, now):
                    self._delete(kind, name)
                    self._aside.end_purge(kind, name)
            except (ModallabError, OSError) as error:
                LOG.warning("%s %s could not be purged: %s", kind, name, error)

    def _delete(self, kind: Kind, name: str) -> None:
        if kind == "run":
            self._delete_samples([name], f"run deleted by {self._by(name, kind)}")
            return
        runs = self._repository.runs(name, archived=True, deleted=True)
        self._delete_samples(runs, f"campaign {name} deleted by {self._by(name, kind)}")
        for job in self._repository.jobs(name):
            self._delete_files(job)

    def _by(self, name: str, kind: Kind) -> str:
        found = self._aside.state_of_run(name, "") if kind == "run" else self._aside.state_of_campaign(name)
        return "somebody" if found is None else found.operator

    def _delete_samples(self, runs: Iterable[str], reason: str) -> None:
        for run in runs:
            record = self._store.catalogue.run(run)
            file = self._store.folder / "runs" / f"{run}.h5"
            if record.state in ENDED and file.exists():
                remove_samples(self._store, [RemovableRun(record, file.stat().st_size)], reason)

    def _delete_files(self, job: str) -> None:
        try:
            result = self._jobs.get(job).result
        except UnknownJobError:
            return
        files = result.get("files") if isinstance(result, dict) else None
        for place in files.values() if isinstance(files, dict) else ():
            (self._store.folder / str(place)).unlink(missing_ok=True)
