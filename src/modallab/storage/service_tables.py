"""The service's tables: campaigns, their runs, events, leases, verdicts, idempotency keys, who did what."""

from sqlalchemy import JSON, BigInteger, Boolean, Column, Float, ForeignKey, Integer, String, Table, Text

from modallab.storage.tables import METADATA, append_only

_SEQUENCE = BigInteger().with_variant(Integer, "sqlite")

CAMPAIGNS = Table(
    "campaigns",
    METADATA,
    Column("id", String(64), primary_key=True),
    Column("name", Text, nullable=False),
    Column("note", Text, nullable=False, default=""),
    Column("rig", String(64), nullable=False),
    Column("operator", Text, nullable=False),
    Column("created_utc", String(32), nullable=False),
    Column("revision", Integer, nullable=False, default=1),
    Column("seq", BigInteger),
)

CAMPAIGN_RUNS = Table(
    "campaign_runs",
    METADATA,
    Column("run", String(64), primary_key=True),
    Column("campaign", String(64), ForeignKey("campaigns.id"), nullable=False, index=True),
    Column("rig", String(64), nullable=False),
    Column("operator", Text, nullable=False),
    Column("continues", String(64)),
    Column("code", String(64), nullable=False, default=""),
    Column("seq", BigInteger),
)

RUN_KEYS = Table(
    "run_keys",
    METADATA,
    Column("key", String(128), primary_key=True),
    Column("request", String(64), nullable=False),
    Column("run", String(64), nullable=False),
    Column("created_utc", String(32), nullable=False),
)
"""The idempotency key each run was asked for under, kept by whoever owns the run."""

CAMPAIGN_JOBS = Table(
    "campaign_jobs",
    METADATA,
    Column("n", _SEQUENCE, primary_key=True, autoincrement=True),
    Column("campaign", String(64), ForeignKey("campaigns.id"), nullable=False, index=True),
    Column("job", String(96), nullable=False),
    Column("kind", String(64), nullable=False),
)

EVENTS = Table(
    "events",
    METADATA,
    Column("seq", _SEQUENCE, primary_key=True, autoincrement=True),
    Column("utc", String(32), nullable=False),
    Column("rig", String(64), nullable=False, default=""),
    Column("campaign", String(64), nullable=False, default="", index=True),
    Column("run", String(64), nullable=False, default="", index=True),
    Column("kind", String(32), nullable=False),
    Column("content", JSON, nullable=False),
    sqlite_autoincrement=True,
)

AUDIT = Table(
    "audit",
    METADATA,
    Column("seq", _SEQUENCE, primary_key=True, autoincrement=True),
    Column("utc", String(32), nullable=False),
    Column("operator", Text, nullable=False),
    Column("action", String(64), nullable=False),
    Column("target", Text, nullable=False),
    Column("detail", JSON, nullable=False),
    sqlite_autoincrement=True,
)

LEASES = Table(
    "leases",
    METADATA,
    Column("rig", String(64), primary_key=True),
    Column("id", String(64), nullable=False),
    Column("fence", Integer, nullable=False),
    Column("operator", Text, nullable=False),
    Column("boot", String(64), nullable=False),
    Column("ttl_s", Float, nullable=False),
    Column("expires_s", Float, nullable=False),
)

VERDICTS = Table(
    "verdicts",
    METADATA,
    Column("seq", _SEQUENCE, primary_key=True, autoincrement=True),
    Column("run", String(64), nullable=False, index=True),
    Column("n", Integer, nullable=False),
    Column("accepted", Boolean, nullable=False),
    Column("reason", Text, nullable=False),
    Column("operator", Text, nullable=False),
    Column("utc", String(32), nullable=False),
    sqlite_autoincrement=True,
)

IDEMPOTENCY = Table(
    "idempotency",
    METADATA,
    Column("key", String(128), primary_key=True),
    Column("request", String(64), nullable=False),
    Column("boot", String(64), nullable=False),
    Column("status", Integer),
    Column("headers", JSON, nullable=False, default=dict),
    Column("body", Text, nullable=False, default=""),
    Column("created_utc", String(32), nullable=False),
)

SESSIONS = Table(
    "sessions",
    METADATA,
    Column("id", String(64), primary_key=True),
    Column("created_utc", String(32), nullable=False),
)

USERS = Table(
    "users",
    METADATA,
    Column("name", String(80), primary_key=True),
    Column("role", String(16), nullable=False),
    Column("created_utc", String(32), nullable=False),
    Column("revoked_utc", String(32), nullable=False, default=""),
)

TOKENS = Table(
    "tokens",
    METADATA,
    Column("id", String(16), primary_key=True),
    Column("user", String(80), ForeignKey("users.name"), nullable=False, index=True),
    Column("digest", String(64), nullable=False),
    Column("label", Text, nullable=False, default=""),
    Column("role", String(16)),
    Column("rigs", JSON, nullable=False),
    Column("created_utc", String(32), nullable=False),
    Column("expires_utc", String(32), nullable=False, default=""),
    Column("revoked_utc", String(32), nullable=False, default=""),
)
"""Tokens of users: a hash of each, which opens nothing."""

QUEUE = Table(
    "queue",
    METADATA,
    Column("id", String(64), primary_key=True),
    Column("rig", String(64), nullable=False, index=True),
    Column("campaign", String(64), ForeignKey("campaigns.id"), nullable=False),
    Column("plan", Text, nullable=False),
    Column("place", BigInteger, nullable=False),
    Column("state", String(16), nullable=False),
    Column("run", String(64), nullable=False, default=""),
    Column("reason", Text, nullable=False, default=""),
    Column("note", Text, nullable=False, default=""),
    Column("operator", Text, nullable=False),
    Column("created_utc", String(32), nullable=False),
    Column("estimated_s", Float, nullable=False),
)

PAUSED_QUEUES = Table(
    "paused_queues",
    METADATA,
    Column("rig", String(64), primary_key=True),
    Column("reason", Text, nullable=False),
    Column("operator", Text, nullable=False),
    Column("utc", String(32), nullable=False),
)

SET_ASIDE = Table(
    "set_aside",
    METADATA,
    Column("kind", String(16), primary_key=True),
    Column("id", String(64), primary_key=True),
    Column("state", String(16), nullable=False),
    Column("operator", Text, nullable=False),
    Column("utc", String(32), nullable=False),
    Column("purge_utc", String(32), nullable=False, default=""),
)
"""Campaigns and runs that are archived or deleted."""

RIG_REVISIONS = Table(
    "rig_revisions",
    METADATA,
    Column("seq", _SEQUENCE, primary_key=True, autoincrement=True),
    Column("rig", String(64), nullable=False, index=True),
    Column("description", Text, nullable=False),
    Column("rig_hash", String(64), nullable=False),
    Column("from_file", Boolean, nullable=False),
    Column("reason", Text, nullable=False),
    Column("operator", Text, nullable=False),
    Column("utc", String(32), nullable=False),
    sqlite_autoincrement=True,
)
"""What each rig was believed to be, the oldest first."""

append_only(EVENTS, AUDIT, VERDICTS, RIG_REVISIONS)
