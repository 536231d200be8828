"""Runs whose end nobody reported: the recorder or the service died before. Reported once, and never resumed."""

import time
from collections.abc import Callable
from contextlib import suppress

from sqlalchemy import Engine, func, select

from modallab.core.errors import StorageError
from modallab.core.events import StateChanged
from modallab.service.records.database import reading
from modallab.service.records.event_log import Topic
from modallab.service.rigs.active_run import Diary
from modallab.storage.records import ENDED
from modallab.storage.service_tables import CAMPAIGN_RUNS, EVENTS

CODE = "interrupted"
LOOK_S = 2.0


class Recovery:
    """Looks now and then: a rig's process that outlived its service may die late, and a full disk may take no row."""

    def __init__(self, diary: Diary, ended: Callable[[str], None] | None = None, look_s: float = LOOK_S) -> None:
        """Begin with the runs whose end is not in the log of events.

        Args:
            diary: where it writes.
            ended: called with the name of every run whose end is reported here.
            look_s: between two looks at least.

        Raises:
            StorageError: the log cannot be read.
        """
        self._diary = diary
        self._ended = ended
        self._look_s = look_s
        self._unreported = unreported(diary.engine)
        self._looked_s = float("-inf")

    def look(self) -> None:
        """Mark what is there to be marked, and report what is there to be reported.

        Raises:
            StorageError: it could not be kept; the next look tries again.
        """
        now = time.monotonic()
        if now - self._looked_s < self._look_s:
            return
        self._looked_s = now
        self._unreported |= set(self._diary.store.recover())
        for run in sorted(self._unreported):
            # Who follows a run hears of its recorder's death at the same moment, and reports it.
            if self._diary.ends.left_alone(run):
                self._notify(run)

    def _notify(self, run: str) -> None:
        record = self._diary.store.catalogue.run(run)
        if record.state not in ENDED:
            return
        self._unreported.discard(run)
        if not self._diary.ends.notify(run):
            return
        entry = self._diary.repository.entry(run)
        topic = Topic(run=run) if entry is None else Topic(entry.rig, entry.campaign, run)
        if record.state == "failed" and entry is not None and not entry.code:
            with suppress(StorageError):
                self._diary.repository.set_code(run, CODE)
        said = StateChanged(run=run, state=record.state, reason=record.reason)
        self._diary.log.append("state", topic, said.model_dump())
        if self._ended is not None:
            self._ended(run)


def unreported(engine: Engine) -> set[str]:
    """Runs of the repository whose last state in the log of events is not their end.

    Raises:
        StorageError: the tables cannot be read.
    """
    of_a_run = select(func.max(EVENTS.c.seq)).where(EVENTS.c.kind == "state", EVENTS.c.run != "").group_by(EVENTS.c.run)
    query = select(EVENTS.c.run, EVENTS.c.content).where(EVENTS.c.seq.in_(of_a_run))
    with reading(engine) as connection:
        reported = {row.run for row in connection.execute(query) if row.content["state"] in ENDED}
        return set(connection.scalars(select(CAMPAIGN_RUNS.c.run))) - reported
