"""Brings the catalogue of an older data folder to this version, a numbered step at a time."""

from collections.abc import Callable, Mapping

from sqlalchemy import Connection, insert, inspect, select, text, update

from modallab.core.errors import FormatError
from modallab.core.versions import STORE as NEWEST
from modallab.storage.tables import DROPPED, METADATA, REMOVED, STORE

Step = Callable[[Connection], None]

_LOCK = 0x6D6F64616C
"""PostgreSQL's advisory lock while tables are made; the one that the table of jobs uses too."""


def migrate_tables(
    connection: Connection, where: str, steps: Mapping[int, Step] | None = None, newest: int = NEWEST
) -> None:
    """Make the tables of a new catalogue, or bring those of an older one up to date.

    All happens in the transaction of `connection`: the catalogue is of the old version or of the new one, never
    between. Two processes that open a folder at once do it one after the other.

    Args:
        connection: in a transaction that may write.
        where: for messages.
        steps: version -> the step to it from the version before; the project's own if None.
        newest: the version to reach.

    Raises:
        FormatError: the catalogue is of a version this program does not know.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(text("SELECT pg_advisory_xact_lock(:n)"), {"n": _LOCK})
    found = _stored_version(connection)
    if found is not None and not 1 <= found <= newest:
        raise FormatError(
            f"the data folder has format version {found}, this program knows up to {newest}",
            where=where,
            remedy="use the newer modallab that wrote it",
        )
    for version in range((found or newest) + 1, newest + 1):
        (STEPS if steps is None else steps)[version](connection)
    METADATA.create_all(connection)
    if found is None:
        connection.execute(insert(STORE).values(format_version=newest))
    elif found != newest:
        connection.execute(update(STORE).values(format_version=newest))


def _stored_version(connection: Connection) -> int | None:
    if not inspect(connection).has_table(STORE.name):
        return None
    return connection.scalar(select(STORE.c.format_version))


def _blocks_may_be_left_out(connection: Connection) -> None:
    # An older program would go on counting blocks that were dropped, so this is a version of its own.
    DROPPED.create(connection, checkfirst=True)
    REMOVED.create(connection, checkfirst=True)


def _what_came_first_is_numbered(connection: Connection) -> None:
    # Names begin with the time of day, which a clock that is set back gives twice. Older rows have nothing better.
    for table, name in (("runs", "id"), ("campaigns", "id"), ("campaign_runs", "run")):
        if not inspect(connection).has_table(table):
            continue
        connection.execute(text(f"ALTER TABLE {table} ADD COLUMN seq BIGINT"))
        before = f"SELECT count(*) FROM {table} AS other WHERE other.{name} <= {table}.{name}"
        connection.execute(text(f"UPDATE {table} SET seq = ({before})"))


STEPS: Mapping[int, Step] = {2: _blocks_may_be_left_out, 3: _what_came_first_is_numbered}
"""Version -> the step that leads to it. A step is never changed once it was released."""
