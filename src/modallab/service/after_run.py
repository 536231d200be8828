"""What happens by itself when a run has ended: its model is identified."""

import logging

from modallab.core.errors import ModallabError
from modallab.jobs import Job, Jobs
from modallab.service.records.campaign_jobs import remember
from modallab.service.records.repository import CampaignRepository
from modallab.storage import Store

LOG = logging.getLogger(__name__)


class AfterRun:
    """Orders the identification of every run that ended with good blocks."""

    def __init__(self, store: Store, jobs: Jobs) -> None:
        self._store = store
        self._jobs = jobs
        self._repository = CampaignRepository(store.catalogue.engine)

    def __call__(self, run: str) -> None:
        """Order it; what keeps it from being ordered is in the log of the service, and it can be ordered again."""
        try:
            if self.worth_identifying(run):
                self.identify(run)
        except ModallabError as error:
            LOG.warning("run %s: not identified: %s", run, error)

    def worth_identifying(self, run: str) -> bool:
        """Whether a run ended well and has blocks that count."""
        record = self._store.catalogue.run(run)
        blocks = self._store.catalogue.blocks(run)
        return record.state == "done" and any(block.note.accepted for block in blocks)

    def identify(self, run: str) -> Job:
        """Order the model of a run and of all it continues."""
        job = self._jobs.submit("identify", {}, self._repository.chain(run))
        entry = self._repository.entry(run)
        if entry is not None:
            remember(self._store.catalogue.engine, entry.campaign, job, "service")
        return job
