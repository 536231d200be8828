"""The table of jobs."""

import logging
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from typing import Any, cast

from sqlalchemy import (
    JSON,
    BigInteger,
    Column,
    Connection,
    Engine,
    Float,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    inspect,
    text,
)
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError, SQLAlchemyError

from modallab.core.errors import DatabaseLostError, RowDamagedError, StorageError
from modallab.jobs.job import Job

LOG = logging.getLogger(__name__)
METADATA = MetaData()

JOBS = Table(
    "jobs",
    METADATA,
    # Counts orders: pages are cut at it.
    Column("n", BigInteger().with_variant(Integer, "sqlite"), primary_key=True, autoincrement=True),
    Column("id", String(96), nullable=False, unique=True),
    Column("key", String(64), nullable=False),
    Column("kind", String(64), nullable=False),
    Column("parameters", JSON, nullable=False),
    Column("inputs", JSON, nullable=False),
    Column("code_version", String(64), nullable=False),
    Column("revision", String(64), nullable=False, default="", server_default=""),
    Column("state", String(16), nullable=False),
    # What somebody waits for, 0, goes before what is done by itself, 1.
    Column("priority", Integer, nullable=False, default=0, server_default="0"),
    Column("progress", Float, nullable=False, default=0.0),
    Column("stage", String(128), nullable=False, default="", server_default=""),
    Column("attempts", Integer, nullable=False, default=0),
    # Grows with every change of owner: what was computed under an older one is not taken.
    Column("fence", Integer, nullable=False, default=0),
    Column("owner", String(96), nullable=False, default=""),
    # Counts the signs of life of the job's holder. Only that it changes says anything: it was a time of day once.
    Column("beat", Float, nullable=False, default=0.0),
    Column("created_utc", String(32), nullable=False),
    Column("ended_utc", String(32), nullable=False, default=""),
    Column("result", JSON(none_as_null=True)),
    Column("error", Text),
    sqlite_autoincrement=True,
)
_ALIVE = text("state IN ('queued', 'running', 'done')")
# What is requested twice is done once, even if two ask at the same instant. What failed may be asked for again.
Index("jobs_one_of_a_key", JOBS.c.key, unique=True, sqlite_where=_ALIVE, postgresql_where=_ALIVE)
Index("jobs_by_state", JOBS.c.state, JOBS.c.n)

_LOCK = 0x6D6F64616C
"""PostgreSQL's advisory lock while tables are made; any number all processes agree on."""
_BEAT_BEFORE = "lease_until"


def make_table(engine: Engine) -> None:
    """Make the table if it is not there, also if several processes begin at once."""
    with engine.begin() as connection:
        if connection.dialect.name == "postgresql":
            connection.execute(text("SELECT pg_advisory_xact_lock(:n)"), {"n": _LOCK})
        _bring_up_to_date(connection)
        METADATA.create_all(connection)


def _bring_up_to_date(connection: Connection) -> None:
    if not inspect(connection).has_table(JOBS.name):
        return
    known = {column["name"] for column in inspect(connection).get_columns(JOBS.name)}
    if _BEAT_BEFORE in known:
        connection.execute(text(f"ALTER TABLE {JOBS.name} RENAME COLUMN {_BEAT_BEFORE} TO beat"))
    if JOBS.c.revision.name not in known:
        connection.execute(text(f"ALTER TABLE {JOBS.name} ADD COLUMN revision VARCHAR(64) DEFAULT '' NOT NULL"))
    if JOBS.c.priority.name not in known:
        connection.execute(text(f"ALTER TABLE {JOBS.name} ADD COLUMN priority INTEGER DEFAULT 0 NOT NULL"))
    if JOBS.c.stage.name not in known:
        connection.execute(text(f"ALTER TABLE {JOBS.name} ADD COLUMN stage VARCHAR(128) DEFAULT '' NOT NULL"))


def job_of(row: Mapping[Any, Any]) -> Job:
    """A row as a job; one that was read without its result has none."""
    values = {name: row[name] for name in Job.model_fields if name != "inputs" and name in row}
    return Job(inputs=tuple(cast("list[str]", row["inputs"])), **values)


@contextmanager
def database_errors(engine: Engine) -> Generator[None]:
    """What the database's driver raises, as errors of our own.

    Raises:
        DatabaseLostError: its server cannot be reached.
        StorageError: anything else.
    """
    try:
        yield
    except SQLAlchemyError as error:
        where = engine.url.render_as_string(hide_password=True)
        if (
            isinstance(error, OperationalError | InterfaceError) or getattr(error, "connection_invalidated", False)
        ) and engine.dialect.name != "sqlite":
            raise DatabaseLostError(
                "the database cannot be reached", where=where, remedy="check the database server, and try again"
            ) from error
        # The driver's words hold SQL and values: they are for the log.
        LOG.warning("%s: %s", where, error.orig if isinstance(error, DBAPIError) else error)
        raise StorageError(
            "the table of jobs cannot be used",
            where=where,
            remedy="check the database and its disk; see the log",
        ) from error
    except ValueError as error:
        LOG.warning("an unreadable job", exc_info=error)
        raise RowDamagedError(
            f"a row of the table of jobs cannot be read: {type(error).__name__}",
            where=engine.url.render_as_string(hide_password=True),
            remedy="restore the database from a backup; the log has the row",
        ) from error
