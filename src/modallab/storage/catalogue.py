"""The catalogue of runs and blocks: a database whose rows are the truth about what was kept."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from pydantic import TypeAdapter
from sqlalchemy import Connection, insert, inspect, select, text, update

from modallab.core.errors import FormatError, StorageError
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.core.versions import STORE as NEWEST
from modallab.storage.engine import database_address, next_number, open_engine, read_transaction, write_transaction
from modallab.storage.records import ENDED, BlockNote, BlockRecord, RunRecord, SamplingRates
from modallab.storage.service_tables import VERDICTS
from modallab.storage.tables import BLOCKS, DROPPED, METADATA, REMOVED, RUNS, STORE

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
            remedy="use the newer version of modallab",
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


_PLAN: TypeAdapter[Plan] = TypeAdapter(Plan)


class RunCatalogue:
    """Rows of runs and blocks, each committed and on the disk when its method returns."""

    def __init__(self, url: str) -> None:
        """Open the database at an SQLAlchemy URL, and make its tables if there are none.

        Raises:
            StorageError: it cannot be opened or written.
            FormatError: it is of a version this program does not know.
        """
        self.engine = open_engine(url)
        self.where = database_address(self.engine)
        with write_transaction(self.engine) as connection:
            migrate_tables(connection, self.where)

    def add_run(self, run: RunRecord) -> None:
        """Commit a new run."""
        with write_transaction(self.engine) as connection:
            connection.execute(insert(RUNS).values(_run_row(run) | {"seq": next_number(connection, RUNS)}))

    def update_run(self, run: str, **values: Any) -> None:
        """Commit new values for columns of a run, such as its state."""
        with write_transaction(self.engine) as connection:
            connection.execute(update(RUNS).where(RUNS.c.id == run).values(values))

    def add_block(self, block: BlockRecord) -> None:
        """Commit a block, whose samples must be on the disk by now."""
        with write_transaction(self.engine) as connection:
            connection.execute(insert(BLOCKS).values(_block_row(block)))

    def drop_block(self, run: str, n: int, reason: str, utc: str) -> None:
        """Commit that a block no longer counts, and why; its samples and its row stay. Once only: the first holds."""
        known = select(DROPPED.c.n).where(DROPPED.c.run == run, DROPPED.c.n == n)
        with write_transaction(self.engine) as connection:
            if connection.scalar(known) is None:
                connection.execute(insert(DROPPED).values(run=run, n=n, reason=reason, utc=utc))

    def judge_block(self, run: str, n: int, *, accepted: bool, reason: str, operator: str, utc: str) -> None:
        """Commit an operator's word on a block; the last one holds, also over a drop."""
        row = {"run": run, "n": n, "accepted": accepted, "reason": reason, "operator": operator, "utc": utc}
        with write_transaction(self.engine) as connection:
            connection.execute(insert(VERDICTS).values(row))

    def remove_samples(self, run: str, reason: str, size: int) -> None:
        """Commit that a run's samples are deleted; its row and those of its blocks stay. Once only: the first holds."""
        with write_transaction(self.engine) as connection:
            if connection.scalar(select(REMOVED.c.run).where(REMOVED.c.run == run)) is None:
                row = {"run": run, "reason": reason, "bytes": size, "utc": datetime.now(UTC).isoformat("T", "seconds")}
                connection.execute(insert(REMOVED).values(row))

    def runs_without_samples(self) -> dict[str, str]:
        """Runs whose samples were deleted, each with when and why."""
        with read_transaction(self.engine) as connection:
            return {row.run: f"{row.utc}: {row.reason}" for row in connection.execute(select(REMOVED))}

    def runs(self) -> tuple[RunRecord, ...]:
        """All runs, in the order they were begun."""
        with read_transaction(self.engine) as connection:
            return tuple(_run_of_row(row) for row in connection.execute(select(RUNS).order_by(RUNS.c.seq)).mappings())

    def runs_without_end(self) -> tuple[str, ...]:
        """Names of the runs that are going on, or were when their recorder died, in the order they were begun."""
        query = select(RUNS.c.id).where(RUNS.c.state.not_in(ENDED)).order_by(RUNS.c.seq)
        with read_transaction(self.engine) as connection:
            return tuple(connection.scalars(query))

    def run(self, run: str) -> RunRecord:
        """One run.

        Raises:
            StorageError: there is none of this name.
        """
        with read_transaction(self.engine) as connection:
            row = connection.execute(select(RUNS).where(RUNS.c.id == run)).mappings().one_or_none()
            if row is None:
                raise StorageError(f"there is no run {run!r}", where=self.where, remedy="read the list of runs")
            return _run_of_row(row)

    def blocks(self, run: str) -> tuple[BlockRecord, ...]:
        """The blocks of a run, in the order they were recorded; a dropped one is not accepted, with that reason."""
        query = select(BLOCKS).where(BLOCKS.c.run == run).order_by(BLOCKS.c.n)
        gone = select(DROPPED.c.n, DROPPED.c.reason).where(DROPPED.c.run == run)
        with read_transaction(self.engine) as connection:
            reasons: dict[int, str] = {row.n: row.reason for row in connection.execute(gone)}
            rows = [_block_of_row(row) for row in connection.execute(query).mappings()]
            words = {row["n"]: row for row in connection.execute(_verdicts_on_run(run)).mappings()}
        now = (_as_dropped(row, reasons[row.n]) if row.n in reasons else row for row in rows)
        return tuple(_as_judged(row, words[row.n]) if row.n in words else row for row in now)

    def close(self) -> None:
        """Let go of the database."""
        self.engine.dispose()


def _run_row(run: RunRecord) -> dict[str, Any]:
    return {
        "id": run.id,
        "test": run.test,
        "state": run.state,
        "reason": run.reason,
        "valid": run.valid,
        "plan": run.plan.model_dump_json(),
        "rig": run.rig.model_dump_json(),
        "rig_hash": run.rig_hash,
        "bench_url": run.bench_url,
        "facts": run.facts,
        "code_version": run.code_version,
        "created_utc": run.created_utc,
        "ended_utc": run.ended_utc,
    }


def _run_of_row(row: Any) -> RunRecord:
    rates = None
    if row["rate_hz"] is not None:
        rates = SamplingRates(row["requested_rate_hz"], row["actual_rate_hz"], row["rate_hz"])
    return RunRecord(
        id=row["id"],
        test=row["test"],
        state=row["state"],
        reason=row["reason"],
        valid=row["valid"],
        plan=_PLAN.validate_json(row["plan"]),
        rig=Rig.model_validate_json(row["rig"]),
        rig_hash=row["rig_hash"],
        bench_url=row["bench_url"],
        facts=row["facts"],
        code_version=row["code_version"],
        created_utc=row["created_utc"],
        ended_utc=row["ended_utc"],
        rates=rates,
        dtype=row["dtype"],
        scale=tuple(row["scale"]),
        units=tuple(row["units"]),
    )


_OWN = ("run", "n", "offset", "count", "crc32", "monotonic_s", "utc")
_NOTE = (
    "name", "test", "first_sample", "drive_point", "level", "frequency_hz", "accepted", "reason", "overload", "facts",
)  # fmt: skip


def _block_row(block: BlockRecord) -> dict[str, Any]:
    row: dict[str, Any] = {key: getattr(block, key) for key in _OWN}
    return row | {key: getattr(block.note, key) for key in _NOTE} | {"overload": list(block.note.overload)}


RENAMED = {
    "at_rest_before": "settled_before",
    "rest_level": "motion_level",
    "rest_excess": "motion_excess",
    "rest_line_hz": "motion_line_hz",
}
"""Facts of a block as older programs wrote them -> as they are called now; the rows stay as they are."""


def _block_of_row(row: Any) -> BlockRecord:
    note: dict[str, Any] = {key: row[key] for key in _NOTE} | {"overload": tuple(row["overload"])}
    note["facts"] = {RENAMED.get(key, key): value for key, value in row["facts"].items()}
    return BlockRecord(**{key: row[key] for key in _OWN}, note=BlockNote(**note))


def _as_dropped(block: BlockRecord, reason: str) -> BlockRecord:
    return replace(block, note=replace(block.note, accepted=False, reason=reason))


def _verdicts_on_run(run: str) -> Any:
    return select(VERDICTS).where(VERDICTS.c.run == run).order_by(VERDICTS.c.seq)


def _as_judged(block: BlockRecord, word: Any) -> BlockRecord:
    reason = f"{word['reason']} (by {word['operator']})" if word["operator"] else word["reason"]
    return replace(block, note=replace(block.note, accepted=word["accepted"], reason=reason))
