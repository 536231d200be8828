"""Runs and blocks as the service shows them, and the operator's judgement of a block."""

from sqlalchemy import select

from modallab.core.documents.runs import BlockView, RunView
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.records.database import reading
from modallab.service.rigs.transitions import legal_after
from modallab.storage.records import BlockRecord, RunRecord
from modallab.storage.tables import RUNS


def record_of(service: Service, run: str) -> RunRecord:
    """One run.

    Raises:
        NotFoundError: there is none of this name.
    """
    with reading(service.engine) as connection:
        known = connection.scalar(select(RUNS.c.id).where(RUNS.c.id == run))
    if known is None:
        raise NotFoundError(f"there is no run {run!r}", remedy="look at the list of runs of its campaign")
    return service.store.catalogue.run(run)


def run_view(service: Service, run: str) -> RunView:
    """A run as it stands.

    Raises:
        NotFoundError: there is none of this name.
    """
    record = record_of(service, run)
    entry = service.repository.entry(run)
    blocks = service.store.catalogue.blocks(run)
    return RunView(
        id=run,
        campaign=None if entry is None else entry.campaign,
        rig=None if entry is None else entry.rig,
        test=record.test,
        state=record.state,
        reason=record.reason,
        code="" if entry is None else entry.code,
        valid=record.valid,
        legal=legal_after(record.state),
        plan=record.plan,
        operator="" if entry is None else entry.operator,
        continues=None if entry is None else entry.continues,
        created_utc=record.created_utc,
        ended_utc=record.ended_utc,
        blocks=len(blocks),
        accepted=sum(block.note.accepted for block in blocks),
        rate_hz=None if record.rates is None else record.rates.delivered_hz,
    )


def block_records(service: Service, run: str) -> tuple[BlockRecord, ...]:
    """All blocks of a run.

    Raises:
        NotFoundError: there is no such run.
    """
    record_of(service, run)
    return service.store.catalogue.blocks(run)


def block_record(service: Service, run: str, n: int) -> BlockRecord:
    """One block.

    Raises:
        NotFoundError: there is no such run or block.
    """
    for block in block_records(service, run):
        if block.n == n:
            return block
    raise NotFoundError(f"run {run} has no block {n}", remedy="look at the list of its blocks")


def block_view(block: BlockRecord) -> BlockView:
    """A block as it stands."""
    note = block.note
    return BlockView(
        run=block.run,
        n=block.n,
        name=note.name,
        first_sample=note.first_sample,
        count=block.count,
        crc32=block.crc32,
        accepted=note.accepted,
        reason=note.reason,
        utc=block.utc,
        drive_point=note.drive_point,
        level=note.level,
        frequency_hz=note.frequency_hz,
        overload=note.overload,
        facts=note.facts,
    )
