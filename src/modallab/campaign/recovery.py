"""Runs whose recorder is gone and could not say how they ended: marked, told, and never resumed by themselves."""

import time
from contextlib import suppress

from modallab.campaign.active_run import Diary
from modallab.campaign.event_log import Topic
from modallab.errors import StorageError
from modallab.schema.events import StateChanged

CODE = "interrupted"
LOOK_S = 2.0


class Recovery:
    """Looks now and then: a rig's process that outlived its service may die late, and a full disk may take no row."""

    def __init__(self, diary: Diary) -> None:
        self._diary = diary
        self._looked_s = float("-inf")

    def look(self) -> None:
        """Mark what is there to be marked.

        Raises:
            StorageError: it could not be kept; the next look tries again.
        """
        now = time.monotonic()
        if now - self._looked_s < LOOK_S:
            return
        self._looked_s = now
        for run in self._diary.store.recover():
            self._tell(run)

    def _tell(self, run: str) -> None:
        entry = self._diary.book.entry(run)
        reason = self._diary.store.catalogue.run(run).reason
        topic = Topic(run=run) if entry is None else Topic(entry.rig, entry.campaign, run)
        self._diary.log.append("state", topic, StateChanged(run=run, state="failed", reason=reason).model_dump())
        with suppress(StorageError):
            self._diary.book.set_code(run, CODE)
