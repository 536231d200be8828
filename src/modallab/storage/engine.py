"""The database: SQLite in the data folder, or PostgreSQL by its address; and transactions on it."""

import logging
import os
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

from sqlalchemy import Connection, Engine, Table, create_engine, event, func, select, text
from sqlalchemy.engine import make_url
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import (
    ArgumentError,
    DBAPIError,
    InterfaceError,
    NoSuchModuleError,
    OperationalError,
    SQLAlchemyError,
)

from modallab.core.discovery import how_to_install
from modallab.core.errors import DatabaseLostError, DiskFullError, FormatError, RowDamagedError, StorageError
from modallab.storage.durable import storage_failure

DATABASE = "modallab.db"
ADDRESS = "database.url"
"""A text file with one line, the address of a PostgreSQL database: every program that opens the folder finds it."""


def database_of(folder: Path) -> str:
    """The SQLAlchemy URL of a data folder's catalogue.

    Raises:
        FormatError: the folder has a catalogue of its own and names a server too.
        StorageError: the address cannot be read.
    """
    own, address = folder / DATABASE, folder / ADDRESS
    if not address.exists():
        return f"sqlite:///{own.as_posix()}"
    if own.exists():
        raise FormatError(
            f"holds both {DATABASE} and {ADDRESS}",
            where=str(folder),
            remedy=f"move its runs to the server with modallab restore, or remove {ADDRESS}",
        )
    try:
        return address.read_text(encoding="utf-8").strip()
    except OSError as error:
        raise StorageError(
            f"cannot be read: {error.strerror}", where=str(address), remedy="check its rights"
        ) from error


def name_database(folder: Path, url: str) -> None:
    """Have a folder keep its catalogue on a server; the file may be read by its owner only.

    Raises:
        FormatError: the folder has a catalogue of its own.
    """
    folder.mkdir(parents=True, exist_ok=True)
    address = folder / ADDRESS
    address.touch(mode=0o600)
    address.write_text(url + "\n", encoding="utf-8")
    try:
        database_of(folder)
    except FormatError:
        address.unlink()
        raise


LOG = logging.getLogger(__name__)
BUSY_S = 30.0
PATIENCE = {
    "connect_timeout": 5,
    "keepalives_idle": 5,
    "keepalives_interval": 2,
    "keepalives_count": 3,
    "tcp_user_timeout": 10_000,
}
"""Until a server that has vanished is given up (libpq): a cable that is out ends no connection by itself."""
_DIALECTS = ("sqlite", "postgresql")


def open_engine(url: str) -> Engine:
    """An engine for an SQLAlchemy URL: `sqlite:///path`, or `postgresql+psycopg://user:password@machine/name`.

    A transaction may write unless its connection has the execution option `reading=True`. Writers to SQLite wait for
    each other for up to `BUSY_S`; readers wait for nobody.

    Raises:
        StorageError: no such kind of database, or its driver is not installed.
    """
    scheme = url.split(":", 1)[0]
    if scheme.partition("+")[0] not in _DIALECTS:
        raise StorageError(
            f"{scheme}: is no database modallab can use",
            where="database",
            remedy="use sqlite:/// or postgresql+psycopg://",
        )
    if scheme.startswith("sqlite"):
        _keep_private(make_url(url).database)
        engine = create_engine(url, connect_args={"timeout": BUSY_S})
        event.listen(engine, "connect", _prepare_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
        return engine
    return _postgresql_engine(url)


def _keep_private(path: str | None) -> None:
    # A new database is for its owner only, as SQLite makes the files beside it then; an older one stays as it is.
    if path and not path.startswith((":", "file:")):
        with suppress(OSError):
            os.close(os.open(path, os.O_CREAT | os.O_EXCL, 0o600))


def _postgresql_engine(url: str) -> Engine:
    try:
        # A server that was restarted is found again by the next transaction.
        return create_engine(
            url.replace("postgresql://", "postgresql+psycopg://", 1), pool_pre_ping=True, connect_args=PATIENCE
        )
    except (ImportError, NoSuchModuleError) as error:
        raise StorageError(
            f"no driver for PostgreSQL: {error}", where="database", remedy=how_to_install("psycopg")
        ) from error
    except (ArgumentError, ValueError) as error:
        raise StorageError(
            "the address is not valid",
            where="database",
            remedy="write it as postgresql+psycopg://user:password@machine:5432/name",
        ) from error


def _prepare_sqlite(connection: DBAPIConnection, _record: object) -> None:
    # The driver would otherwise begin by itself, deferred: a reader that turns writer meets BUSY without a wait.
    connection.isolation_level = None
    cursor = connection.cursor()
    cursor.execute("PRAGMA journal_mode=WAL")
    cursor.execute("PRAGMA synchronous=FULL")
    cursor.execute("PRAGMA foreign_keys=ON")
    # The log beside the database is taken over before it is as large as what a small disk has to spare.
    cursor.execute("PRAGMA wal_autocheckpoint=128")
    cursor.close()


def _begin_sqlite(connection: Connection) -> None:
    reading = connection.get_execution_options().get("reading", False)
    connection.exec_driver_sql("BEGIN" if reading else "BEGIN IMMEDIATE")


@contextmanager
def write_transaction(engine: Engine) -> Generator[Connection]:
    """A transaction that writes.

    Raises:
        DiskFullError, StorageError: nothing of it was kept.
    """
    try:
        with engine.begin() as connection:
            yield connection
    except SQLAlchemyError as error:
        raise _write_failure(error, engine) from error
    except ValueError as error:
        raise _damaged_error(error, engine) from error


@contextmanager
def read_transaction(engine: Engine) -> Generator[Connection]:
    """A transaction that only reads.

    Raises:
        StorageError: the database cannot be read.
    """
    try:
        with engine.connect().execution_options(reading=True) as connection:
            yield connection
    except SQLAlchemyError as error:
        raise server_lost(error, engine) or StorageError(
            f"cannot be read: {_error_text(error, engine)}", where=database_address(engine), remedy="look at the disk"
        ) from error
    except ValueError as error:
        raise _damaged_error(error, engine) from error


def next_number(connection: Connection, table: Table) -> int:
    """One more than the highest `seq` of a table. Numbers say what came after what; a clock that is set does not.

    Held to its end: no other transaction takes the same number.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(text(f"LOCK TABLE {table.name} IN EXCLUSIVE MODE"))
    return (connection.scalar(select(func.max(table.c.seq))) or 0) + 1


def server_lost(error: SQLAlchemyError, engine: Engine) -> DatabaseLostError | None:
    """What to raise where a server cannot be reached; None if it is another error. Its own words are for its log."""
    gone = isinstance(error, (OperationalError, InterfaceError)) or getattr(error, "connection_invalidated", False)
    if engine.dialect.name == "sqlite" or not gone:
        return None
    return DatabaseLostError(
        "the database cannot be reached",
        where=database_address(engine),
        remedy="check the database server, and try again",
    )


def _write_failure(error: SQLAlchemyError, engine: Engine) -> StorageError:
    where = database_address(engine)
    found = error.orig if isinstance(error, DBAPIError) else None
    full = storage_failure(found, where) if isinstance(found, Exception) else None
    if isinstance(full, DiskFullError):
        return full
    return server_lost(error, engine) or StorageError(
        f"cannot be written: {_error_text(error, engine)}",
        where=where,
        remedy="check the disk; all acknowledged blocks are kept",
    )


def _damaged_error(error: ValueError, engine: Engine) -> StorageError:
    LOG.warning("an unreadable row", exc_info=error)
    return RowDamagedError(
        f"a row of the database cannot be read: {type(error).__name__}",
        where=database_address(engine),
        remedy="restore the database from a backup; the log has the row",
    )


SAID = (
    ("locked", "it is busy"),
    ("malformed", "its file is damaged"),
    ("not a database", "its file is no database"),
    ("decode", "a text in the file is damaged"),
    ("readonly", "the file is read-only"),
    ("unable to open", "its file cannot be opened"),
    ("no such", "a table or a column is missing"),
    ("constraint", "a row exists already, or refers to a missing row"),
    ("append-only", "its rows never change"),
    ("I/O", "its disk fails"),
)
"""Part of what a driver says -> our own words. What it says itself holds SQL and values, and is for the log."""


def _error_text(error: SQLAlchemyError, engine: Engine) -> str:
    said = str(error.orig if isinstance(error, DBAPIError) else error)
    LOG.warning("%s: %s", database_address(engine), said)
    return next((ours for theirs, ours in SAID if theirs in said), "it rejects it")


def database_address(engine: Engine) -> str:
    """Its address, without a password."""
    return engine.url.render_as_string(hide_password=True)
