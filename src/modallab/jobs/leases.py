"""The table of jobs, for those who compute them: taking, holding and ending a job under a lease and a fence."""

import time
from collections.abc import Callable, Collection, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from pydantic import JsonValue
from sqlalchemy import Connection, Engine, and_, false, or_, select, update

from modallab.jobs.job import OPEN, Job
from modallab.jobs.jobs import utc_now
from modallab.jobs.table import JOBS, database_errors, job_of

Mark = tuple[int, float]
"""Fence and beat of a job that is held: one of them changes with every sign of its holder."""


class LeaseMarkTimer:
    """Times how long each job's mark has stayed the same.

    No clock on the wall is asked, neither the machine's nor the database's: a clock that is set ends no lease and
    prolongs none. Between two looks at most a part of the lease is counted, so that a watcher that slept, or a database
    that answered nobody, is not taken for a holder that gives no sign.
    """

    def __init__(self, lease_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._lease_s = lease_s
        self._clock = clock
        self._looked_s = clock()
        self._marks: dict[str, Mark] = {}
        self._timeout_s: dict[str, float] = {}

    def check_now(self, held: Mapping[str, Mark]) -> dict[str, Mark]:
        """Note what is held now; those of them that gave no sign for longer than the lease, with their marks."""
        now = self._clock()
        passed = min(now - self._looked_s, self._lease_s / 5)
        self._looked_s = now
        self._timeout_s = {
            job: self._timeout_s[job] + passed if self._marks.get(job) == mark else 0.0 for job, mark in held.items()
        }
        self._marks = dict(held)
        return {job: mark for job, mark in held.items() if self._timeout_s[job] > self._lease_s}


MAX_ATTEMPTS = 3
LEASE_S = 15.0


@dataclass(frozen=True, slots=True)
class LeasedJob:
    """A job under lease. `fence` distinguishes this attempt from all others."""

    job: Job
    fence: int

    @property
    def attempt_name(self) -> str:
        """A name no other attempt has, of any job."""
        return f"{self.job.id}.{self.fence}"


class JobLeases:
    """Jobs of one owner. A job whose holder gave no sign for `lease_s`, as seen from here, is open.

    Every method raises StorageError where the table cannot be used, DatabaseLostError where its server is gone.
    """

    def __init__(self, engine: Engine, owner: str, lease_s: float = LEASE_S) -> None:
        self._engine = engine
        self._owner = owner
        self.lease_s = lease_s
        self._watch = LeaseMarkTimer(lease_s)

    def has_open_job(self) -> bool:
        """Whether a job waits or its owner is gone; takes no lock, and counts time without a sign as `take` does."""
        waiting, timed_out = self._look()
        return waiting or bool(timed_out)

    def lease_jobs(self, kinds: Collection[str], limit: int) -> list[LeasedJob]:
        """Lease up to `limit` jobs that wait or whose owner is gone: what somebody waits for first, then the oldest.

        A job whose owners were lost too often, or whose kind is not among `kinds`, fails here: none waits for ever.
        Time without a sign is counted from call to call, so this is to be called now and then, also with no room for
        more.
        """
        waiting, timed_out = self._look()
        if limit < 1 or not (waiting or timed_out):
            return []
        with self._writing() as connection:
            query = (
                select(JOBS)
                .where(_is_free(timed_out))
                .order_by(JOBS.c.priority, JOBS.c.n)
                .limit(limit)
                .with_for_update(skip_locked=True)
            )
            rows = connection.execute(query).mappings().all()
            return [taken for row in rows if (taken := self._lease(connection, row, kinds)) is not None]

    def renew(self, held: Mapping[str, tuple[int, float, str]]) -> set[str]:
        """Renew leases and note how far each is; returns those that are ours no more.

        Args:
            held: job -> (fence, progress, stage).
        """
        if not held:
            return set()
        lost: set[str] = set()
        with self._writing() as connection:
            for job, (fence, progress, stage) in held.items():
                if not self._change(connection, job, fence, beat=JOBS.c.beat + 1, progress=progress, stage=stage):
                    lost.add(job)
        return lost

    def complete(self, taken: LeasedJob, result: JsonValue) -> bool:
        """Commit a result; False if the job was cancelled or taken by another meanwhile, and nothing was written."""
        return self._end(taken, state="done", progress=1.0, stage="", result=result)

    def fail(self, taken: LeasedJob, error: str) -> bool:
        """Commit a failure that would come again; False as for `done`."""
        return self._end(taken, state="failed", error=error)

    def give_back(self, taken: LeasedJob, why: str, *, counts: bool) -> bool:
        """Let another attempt be made; False as for `done`.

        Args:
            taken: the job.
            why: what was lost; it becomes the error if attempts run out.
            counts: whether it counts as an attempt: the loss of a machine does, an orderly stop does not.
        """
        attempts = taken.job.attempts if counts else taken.job.attempts - 1
        if attempts >= MAX_ATTEMPTS:
            return self.fail(taken, _gave_up(attempts, why))
        with self._writing() as connection:
            back = {"state": "queued", "owner": "", "progress": 0.0, "stage": "", "attempts": attempts}
            return self._change(connection, taken.job.id, taken.fence, **back)

    def _look(self) -> tuple[bool, dict[str, Mark]]:
        # A look takes no lock that a recording would wait for.
        query = select(JOBS.c.id, JOBS.c.state, JOBS.c.fence, JOBS.c.beat).where(JOBS.c.state.in_(sorted(OPEN)))
        with database_errors(self._engine), self._engine.connect().execution_options(reading=True) as connection:
            rows = connection.execute(query).all()
        held = {row.id: (row.fence, row.beat) for row in rows if row.state == "running"}
        return len(rows) > len(held), self._watch.check_now(held)

    def _lease(self, connection: Connection, row: Mapping[Any, Any], kinds: Collection[str]) -> LeasedJob | None:
        fence, attempts = row["fence"] + 1, row["attempts"] + 1
        error = None
        if row["kind"] not in kinds:
            error = f"no kind {row['kind']!r} is registered; there are {', '.join(sorted(kinds))}"
        elif attempts > MAX_ATTEMPTS:
            error = _gave_up(row["attempts"], "its runner ended without notice")
        if error is not None:
            values = {"state": "failed", "error": error, "ended_utc": utc_now(), "fence": fence, "owner": ""}
        else:
            values = {"state": "running", "owner": self._owner, "fence": fence, "attempts": attempts}
            values |= {"progress": 0.0, "stage": ""}
        connection.execute(update(JOBS).where(JOBS.c.id == row["id"]).values(values))
        return LeasedJob(job_of(dict(row) | values), fence) if error is None else None

    def _end(self, taken: LeasedJob, **values: Any) -> bool:
        with self._writing() as connection:
            return self._change(connection, taken.job.id, taken.fence, owner="", ended_utc=utc_now(), **values)

    @contextmanager
    def _writing(self) -> Generator[Connection]:
        with database_errors(self._engine), self._engine.begin() as connection:
            yield connection

    def _change(self, connection: Connection, job: str, fence: int, **values: Any) -> bool:
        mine = and_(JOBS.c.id == job, JOBS.c.fence == fence, JOBS.c.state == "running", JOBS.c.owner == self._owner)
        return connection.execute(update(JOBS).where(mine).values(values)).rowcount == 1


def _is_free(timed_out: Mapping[str, Mark]) -> Any:
    # Whoever gave a sign since the look, or took the job, has changed its mark.
    theirs = (
        and_(JOBS.c.id == job, JOBS.c.fence == fence, JOBS.c.beat == beat) for job, (fence, beat) in timed_out.items()
    )
    return or_(JOBS.c.state == "queued", and_(JOBS.c.state == "running", or_(false(), *theirs)))


def _gave_up(attempts: int, why: str) -> str:
    return (
        f"given up after {attempts} attempts, the last one because {why}\n"
        "  what to do: check memory and logs of the computing machines, then order the job again"
    )
