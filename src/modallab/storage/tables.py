"""The catalogue's tables; rows of append-only ones never change and never leave, by the database's own word."""

from sqlalchemy import (
    DDL,
    JSON,
    BigInteger,
    Boolean,
    Column,
    Float,
    ForeignKey,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    event,
)

_REJECT = """
CREATE OR REPLACE FUNCTION modallab_append_only() RETURNS trigger AS $$
BEGIN RAISE EXCEPTION '%% are append-only', TG_TABLE_NAME USING ERRCODE = 'integrity_constraint_violation'; END
$$ LANGUAGE plpgsql"""


def append_only(*tables: Table) -> None:
    """Have every database that gets these tables reject to update or delete their rows."""
    for table in tables:
        for verb in ("UPDATE", "DELETE"):
            _sqlite_trigger(table, verb)
        event.listen(table, "after_create", DDL(_REJECT).execute_if(dialect="postgresql"))
        event.listen(table, "after_create", DDL(_append_only_trigger(table)).execute_if(dialect="postgresql"))


def _sqlite_trigger(table: Table, verb: str) -> None:
    text = (
        f"CREATE TRIGGER {table.name}_no_{verb.lower()} BEFORE {verb} ON {table.name} "
        f"BEGIN SELECT RAISE(ABORT, '{table.name} are append-only'); END"
    )
    event.listen(table, "after_create", DDL(text).execute_if(dialect="sqlite"))


def _append_only_trigger(table: Table) -> str:
    return (
        f"CREATE TRIGGER {table.name}_append_only BEFORE UPDATE OR DELETE ON {table.name} "
        "FOR EACH ROW EXECUTE FUNCTION modallab_append_only()"
    )


METADATA = MetaData()

STORE = Table("store", METADATA, Column("format_version", Integer, nullable=False))

RUNS = Table(
    "runs",
    METADATA,
    Column("id", String(64), primary_key=True),
    Column("test", String(16), nullable=False),
    Column("state", String(16), nullable=False),
    Column("reason", Text, nullable=False, default=""),
    Column("valid", Boolean, nullable=False, default=True),
    Column("plan", Text, nullable=False),
    Column("rig", Text, nullable=False),
    Column("rig_hash", String(64), nullable=False),
    Column("bench_url", Text, nullable=False),
    Column("facts", JSON, nullable=False),
    Column("code_version", String(64), nullable=False),
    Column("created_utc", String(32), nullable=False),
    Column("ended_utc", String(32), nullable=False, default=""),
    Column("requested_rate_hz", Float),
    Column("actual_rate_hz", Float),
    Column("rate_hz", Float),
    Column("dtype", String(8), nullable=False, default=""),
    Column("scale", JSON, nullable=False, default=list),
    Column("units", JSON, nullable=False, default=list),
    Column("seq", BigInteger),
)

BLOCKS = Table(
    "blocks",
    METADATA,
    Column("run", String(64), ForeignKey("runs.id"), primary_key=True),
    Column("n", Integer, primary_key=True),
    Column("name", Text, nullable=False),
    Column("offset", BigInteger, nullable=False),
    Column("first_sample", BigInteger, nullable=False),
    Column("count", Integer, nullable=False),
    Column("crc32", BigInteger, nullable=False),
    Column("monotonic_s", Float, nullable=False),
    Column("utc", String(32), nullable=False),
    Column("accepted", Boolean, nullable=False),
    Column("reason", Text, nullable=False),
    Column("test", String(16), nullable=False),
    Column("drive_point", Integer),
    Column("level", Text),
    Column("frequency_hz", Float),
    Column("overload", JSON, nullable=False),
    Column("facts", JSON, nullable=False),
)

DROPPED = Table(
    "dropped",
    METADATA,
    Column("run", String(64), ForeignKey("runs.id"), primary_key=True),
    Column("n", Integer, primary_key=True),
    Column("reason", Text, nullable=False),
    Column("utc", String(32), nullable=False),
)

REMOVED = Table(
    "removed",
    METADATA,
    Column("run", String(64), ForeignKey("runs.id"), primary_key=True),
    Column("reason", Text, nullable=False),
    Column("bytes", BigInteger, nullable=False),
    Column("utc", String(32), nullable=False),
)
"""Runs whose samples were deleted. Their rows stay: what was measured, and that it is gone, remains known."""

append_only(BLOCKS, DROPPED, REMOVED)
