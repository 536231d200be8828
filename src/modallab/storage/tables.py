"""The catalogue's tables."""

from sqlalchemy import (
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
)

from modallab.storage.append_only import append_only

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
