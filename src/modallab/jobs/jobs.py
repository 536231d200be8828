"""The list of jobs, for those who order them."""

import secrets
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Engine, insert, select, update
from sqlalchemy.exc import IntegrityError

from modallab import __version__
from modallab.core.errors import JobError, UnknownJobError
from modallab.jobs.job import OPEN, Job, JobPage, JobState, job_key
from modallab.jobs.table import JOBS, database_errors, job_of, make_table

PAGE = 50
AUTOMATIC = 1
"""Priority of a job that nobody waits for."""
_ALIVE = ("queued", "running", "done")
_BUT_RESULTS = tuple(column for column in JOBS.c if column is not JOBS.c.result)


class Jobs:
    """Jobs in a database. Every change is committed, so on the disk, when its method returns."""

    def __init__(self, engine: Engine) -> None:
        """Use a database, and make the table of jobs if there is none.

        Args:
            engine: SQLite or PostgreSQL, as `modallab.storage.engine.open_engine` gives it.

        Raises:
            StorageError: the database cannot be written.
        """
        self.engine = engine
        with database_errors(engine):
            make_table(engine)

    def submit(
        self,
        kind: str,
        parameters: dict[str, Any],
        inputs: Sequence[str],
        revision: str = "",
        *,
        automatic: bool = False,
    ) -> Job:
        """Order a job. The same work that is waiting, going on or done is not done again: that job is given back.

        Args:
            kind: name of a registered kind.
            parameters: JSON values.
            inputs: names of what it works on.
            revision: of what the inputs hold now, as the kind's `revision` gives it; other contents are other work.
            automatic: nobody waits for it: what somebody ordered goes first.

        Raises:
            JobError: parameters that cannot be kept.
        """
        key = job_key(kind, parameters, inputs, revision, __version__)
        row = {
            "id": _kind_name(kind),
            "key": key,
            "kind": kind,
            "parameters": parameters,
            "inputs": list(inputs),
            "revision": revision,
            "code_version": __version__,
            "state": "queued",
            "priority": AUTOMATIC if automatic else 0,
            "created_utc": utc_now(),
        }
        with database_errors(self.engine):
            job = self._same(key) or self._add(row) or self._same(key) or self._lost(key)
            if job.state == "queued" and not automatic:
                self._put_first(job.id)
            return job

    def supersede(self, newer: Job) -> int:
        """Cancel the automatic jobs that wait for what a newer one does as well: the same, of some of its inputs.

        Returns:
            how many.

        Raises:
            StorageError: the database cannot be written.
        """
        waiting = select(JOBS.c.id, JOBS.c.inputs).where(
            JOBS.c.kind == newer.kind, JOBS.c.state == "queued", JOBS.c.priority == AUTOMATIC, JOBS.c.id != newer.id
        )
        with database_errors(self.engine), self.engine.begin() as connection:
            idle = [row.id for row in connection.execute(waiting) if set(row.inputs) <= set(newer.inputs)]
            ended = {
                "state": "cancelled",
                "ended_utc": utc_now(),
                "error": f"job {newer.id} replaces this job, with more runs",
            }
            mine = JOBS.c.id.in_(idle), JOBS.c.state == "queued", JOBS.c.priority == AUTOMATIC
            return connection.execute(update(JOBS).where(*mine).values(ended)).rowcount

    def jobs_outdated_by(self, name: str, revision: Callable[[tuple[str, ...]], str]) -> list[Job]:
        """Jobs that wait or go on, work on what is called `name`, and were ordered when their inputs held other things.

        Raises:
            StorageError: the database cannot be read.
        """
        query = select(*_BUT_RESULTS).where(JOBS.c.state.in_(sorted(OPEN))).order_by(JOBS.c.n)
        with self._reading() as connection:
            found = [job_of(row) for row in connection.execute(query).mappings()]
        concerned = (job for job in found if job.revision and name in job.inputs)
        return [job for job in concerned if revision(job.inputs) != job.revision]

    def replace(self, job: Job, revision: str) -> Job:
        """Order the work of a job again, of what its inputs hold now, as urgently; the old one is cancelled.

        Raises:
            StorageError: the database cannot be written.
        """
        urgent = select(JOBS.c.priority).where(JOBS.c.id == job.id)
        with self._reading() as connection:
            automatic = connection.scalar(urgent) == AUTOMATIC
        newer = self.submit(job.kind, dict(job.parameters), job.inputs, revision, automatic=automatic)
        self.cancel(job.id, f"the valid blocks have changed: job {newer.id} uses the present ones")
        return newer

    def get(self, job: str) -> Job:
        """One job.

        Raises:
            UnknownJobError: there is none of this name.
        """
        with self._reading() as connection:
            row = connection.execute(select(JOBS).where(JOBS.c.id == job)).mappings().one_or_none()
        if row is None:
            raise UnknownJobError(f"there is no job {job!r}", remedy="look at the list of jobs")
        return job_of(row)

    def list(
        self,
        *,
        state: JobState | None = None,
        kind: str | None = None,
        cursor: str | None = None,
        limit: int = PAGE,
    ) -> JobPage:
        """Jobs, the newest first; without their results, which `get` gives.

        Args:
            state: only those in this state.
            kind: only those of this kind.
            cursor: of the page before; None for the first.
            limit: at most so many.

        Raises:
            JobError: the cursor is none that was given out, or the limit is below 1.
        """
        query = select(*_BUT_RESULTS).order_by(JOBS.c.n.desc()).limit(_limited(limit) + 1)
        if state is not None:
            query = query.where(JOBS.c.state == state)
        if kind is not None:
            query = query.where(JOBS.c.kind == kind)
        if cursor is not None:
            query = query.where(JOBS.c.n < _place_of_cursor(cursor))
        with self._reading() as connection:
            rows = connection.execute(query).mappings().all()
        more = len(rows) > limit
        return JobPage(
            jobs=tuple(job_of(row) for row in rows[:limit]), cursor=str(rows[limit - 1]["n"]) if more else None
        )

    def cancel(self, job: str, why: str | None = None) -> Job:
        """Cancel a job, at once: what is still being computed is stopped by its runner, and not taken.

        A job that has ended stays as it is. `why` is for whoever waits for it.

        Raises:
            UnknownJobError: there is none of this name.
        """
        ended = {"state": "cancelled", "ended_utc": utc_now(), "fence": JOBS.c.fence + 1, "error": why}
        query = update(JOBS).where(JOBS.c.id == job, JOBS.c.state.in_(sorted(OPEN))).values(ended)
        with database_errors(self.engine), self.engine.begin() as connection:
            connection.execute(query)
        return self.get(job)

    def release(self, owner: str) -> int:
        """Let others take the jobs of a runner that is known to be dead, without waiting for its lease to end.

        Returns:
            how many it held. What it might still bring is not taken.

        Raises:
            StorageError: the database cannot be written.
        """
        freed = {"state": "queued", "owner": "", "progress": 0.0, "stage": "", "fence": JOBS.c.fence + 1}
        query = update(JOBS).where(JOBS.c.owner == owner, JOBS.c.state == "running").values(freed)
        with database_errors(self.engine), self.engine.begin() as connection:
            return connection.execute(query).rowcount

    def _put_first(self, job: str) -> None:
        query = update(JOBS).where(JOBS.c.id == job, JOBS.c.state == "queued", JOBS.c.priority > 0).values(priority=0)
        with self.engine.begin() as connection:
            connection.execute(query)

    def _same(self, key: str) -> Job | None:
        query = select(JOBS).where(JOBS.c.key == key, JOBS.c.state.in_(_ALIVE))
        with self._reading() as connection:
            row = connection.execute(query).mappings().one_or_none()
        return None if row is None else job_of(row)

    def _add(self, row: dict[str, Any]) -> Job | None:
        try:
            with self.engine.begin() as connection:
                connection.execute(insert(JOBS).values(row))
        except IntegrityError:
            return None
        return self.get(row["id"])

    def _lost(self, key: str) -> Job:
        # Another's job of this key failed between our two looks: once more, it is free now.
        raise JobError(f"the job of key {key[:12]} ended during the order", remedy="order it again")

    @contextmanager
    def _reading(self) -> Generator[Connection]:
        with (
            database_errors(self.engine),
            self.engine.connect().execution_options(reading=True) as connection,
        ):
            yield connection


def utc_now() -> str:
    """The time for people, ISO 8601 to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _kind_name(kind: str) -> str:
    return f"{datetime.now(UTC):%Y%m%dT%H%M%S}-{kind}-{secrets.token_hex(4)}"


def _limited(limit: int) -> int:
    if limit < 1:
        raise JobError(f"a page of {limit} jobs was requested", where="limit", remedy="ask for at least 1")
    return limit


def _place_of_cursor(cursor: str) -> int:
    if not (cursor.isascii() and cursor.isdigit() and len(cursor) < 19):
        raise JobError(f"{cursor!r} is no cursor", where="cursor", remedy="use the cursor of the previous page")
    return int(cursor)
