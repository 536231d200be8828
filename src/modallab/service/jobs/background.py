"""What happens to jobs without a request: a run that ended is identified, and progress is logged as events."""

import logging
import time

from sqlalchemy import Engine

from modallab.core.documents.messages import JobChanged
from modallab.core.errors import ModallabError, UnknownJobError
from modallab.jobs import Job, Jobs
from modallab.service.records.event_log import EventLog, EventTopic
from modallab.service.records.repository import CampaignRepository
from modallab.storage import Store

LOOK_S = 0.5
STEP = 0.02
"""Progress that is worth an event."""
PAGE = 100


class JobChangeLog:
    """Looks at the open jobs, and logs what has changed since."""

    def __init__(self, engine: Engine, jobs: Jobs, log: EventLog) -> None:
        self._repository = CampaignRepository(engine)
        self._jobs = jobs
        self._log = log
        self._known: dict[str, tuple[str, str, float]] = {}
        self._looked_s = float("-inf")

    def check_now(self) -> None:
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
        stand = (job.state, job.stage, round(job.progress / STEP) * STEP)
        if self._known.get(name) != stand:
            changed = JobChanged(
                job=job.id, of=job.kind, state=job.state, progress=job.progress, stage=job.stage, inputs=job.inputs,
                error=job.error,
            )  # fmt: skip
            topic = EventTopic(campaign=self._repository.campaign_of_job(name))
            self._log.append(changed.kind, topic, changed.model_dump(mode="json"))
        if job.has_ended:
            self._known.pop(name, None)
        else:
            self._known[name] = stand

    def _get(self, name: str) -> Job | None:
        try:
            return self._jobs.get(name)
        except UnknownJobError:
            return None


LOG = logging.getLogger(__name__)


class IdentificationAfterRun:
    """Orders the identification of every run that ended with good blocks, and again if blocks are judged meanwhile."""

    def __init__(self, store: Store, jobs: Jobs) -> None:
        self._store = store
        self._jobs = jobs
        self._repository = CampaignRepository(store.catalogue.engine)

    def __call__(self, run: str) -> None:
        """Order it; what keeps it from being ordered is in the log of the service, and it can be ordered again."""
        try:
            if self.can_be_identified(run):
                self.identify(run)
        except ModallabError as error:
            LOG.warning("run %s: not identified: %s", run, error)

    def block_judged(self, run: str) -> None:
        """A block of an ended run was judged: what waits or goes on is done with the blocks that count now.

        An identification of the run itself is ordered where there is none: it was cancelled, or nothing counted. Where
        one is done, whoever wants another orders it.
        """
        try:
            for job in self._jobs.jobs_outdated_by(run, self._store.revision):
                self._replace(job)
            if self.can_be_identified(run) and not self._identified(run):
                self.identify(run)
        except ModallabError as error:
            LOG.warning("run %s: not identified after a verdict: %s", run, error)

    def _replace(self, job: Job) -> None:
        if not any(self._counts(run) for run in job.inputs):
            self._jobs.cancel(job.id, "none of its blocks is valid any more")
            return
        newer = self._jobs.replace(job, self._store.revision(job.inputs))
        campaign = self._repository.campaign_of_job(job.id)
        if campaign:
            self._repository.add_job(campaign, newer, "service")

    def _identified(self, run: str) -> bool:
        entry = self._repository.run_entry(run)
        names = [] if entry is None else self._repository.jobs(entry.campaign, "identify")
        alive = ("queued", "running", "done")
        return any(run in job.inputs and job.state in alive for job in map(self._jobs.get, names))

    def _counts(self, run: str) -> bool:
        return any(block.note.accepted for block in self._store.catalogue.blocks(run))

    def can_be_identified(self, run: str) -> bool:
        """Whether a run ended well and has blocks that count."""
        return self._store.catalogue.run(run).state == "done" and self._counts(run)

    def identify(self, run: str) -> Job:
        """Order the model of a run and of all it continues."""
        runs = self._repository.runs_continued(run)
        job = self._jobs.submit("identify", {}, runs, self._store.revision(runs), automatic=True)
        self._jobs.supersede(job)
        entry = self._repository.run_entry(run)
        if entry is not None:
            self._repository.add_job(entry.campaign, job, "service")
        return job
