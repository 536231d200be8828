"""Reports in the log of events how jobs go on."""

import time

from sqlalchemy import Engine, select

from modallab.core.errors import UnknownJobError
from modallab.jobs import Job, Jobs
from modallab.service.records.database import reading
from modallab.service.records.event_log import EventLog, Topic
from modallab.storage.service_tables import CAMPAIGN_JOBS

LOOK_S = 0.5
PAGE = 100


class JobWatch:
    """Looks at the open jobs, and reports what has changed since."""

    def __init__(self, engine: Engine, jobs: Jobs, log: EventLog) -> None:
        self._engine = engine
        self._jobs = jobs
        self._log = log
        self._known: dict[str, tuple[str, float]] = {}
        self._looked_s = float("-inf")

    def look(self) -> None:
        """Look, if it is time.

        Raises:
            StorageError: the table cannot be read.
        """
        if time.monotonic() - self._looked_s < LOOK_S:
            return
        self._looked_s = time.monotonic()
        now = {job.id: job for state in ("queued", "running") for job in self._jobs.list(state=state, limit=PAGE).jobs}
        for name in [*now, *(known for known in self._known if known not in now)]:
            self._notify(now.get(name) or self._get(name), name)

    def _notify(self, job: Job | None, name: str) -> None:
        if job is None:
            self._known.pop(name, None)
            return
        stand = (job.state, round(job.progress, 1))
        if self._known.get(name) != stand:
            content = {"kind": "job", "job": job.id, "of": job.kind, "state": job.state, "progress": job.progress}
            content |= {"inputs": list(job.inputs), "error": job.error}
            self._log.append("job", Topic(campaign=self._campaign(name)), content)
        if job.ended:
            self._known.pop(name, None)
        else:
            self._known[name] = stand

    def _get(self, name: str) -> Job | None:
        try:
            return self._jobs.get(name)
        except UnknownJobError:
            return None

    def _campaign(self, job: str) -> str:
        query = select(CAMPAIGN_JOBS.c.campaign).where(CAMPAIGN_JOBS.c.job == job).limit(1)
        with reading(self._engine) as connection:
            return connection.scalar(query) or ""
