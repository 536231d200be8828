"""Runs and blocks as the service shows them, and the operator's verdict on a block."""

import numpy as np
from sqlalchemy import select

from modallab.core.documents.messages import BlockJudged
from modallab.core.documents.runs import AcceptHit, BlockVerdict, BlockView, DropHit, RunView
from modallab.service.context import Service
from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.jobs.background import IdentificationAfterRun
from modallab.service.records import audit
from modallab.service.records.archive import ArchivedRecords, archive_state
from modallab.service.records.event_log import EventTopic
from modallab.service.rigs.control import legal_next_states
from modallab.storage.engine import read_transaction
from modallab.storage.recorder import utc_now
from modallab.storage.records import ENDED, BlockRecord, RunRecord
from modallab.storage.samples import Samples, open_samples
from modallab.storage.store import require_intact
from modallab.storage.tables import RUNS


def record_of(service: Service, run: str) -> RunRecord:
    """One run.

    Raises:
        NotFoundError: there is none of this name.
    """
    with read_transaction(service.engine) as connection:
        known = connection.scalar(select(RUNS.c.id).where(RUNS.c.id == run))
    if known is None:
        raise NotFoundError(f"there is no run {run!r}", remedy="read the list of runs of its campaign")
    return service.store.catalogue.run(run)


def run_view(service: Service, run: str) -> RunView:
    """A run in its present state.

    Raises:
        NotFoundError: there is none of this name.
    """
    record = record_of(service, run)
    entry = service.repository.run_entry(run)
    blocks = service.store.catalogue.blocks(run)
    aside = None if entry is None else ArchivedRecords(service.engine).state_of_run(run, entry.campaign)
    return RunView.of_fields(
        record,
        campaign=None if entry is None else entry.campaign,
        rig=None if entry is None else entry.rig,
        code="" if entry is None else entry.code,
        legal=legal_next_states(record.state),
        operator="" if entry is None else entry.operator,
        continues=None if entry is None else entry.continues,
        blocks=len(blocks),
        accepted=sum(block.note.accepted for block in blocks),
        rate_hz=None if record.rates is None else record.rates.delivered_hz,
        **archive_state(aside),
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
    raise NotFoundError(f"run {run} has no block {n}", remedy="read the list of its blocks")


def block_view(block: BlockRecord) -> BlockView:
    """A block as it stands."""
    return BlockView.of_fields(block, block.note)


def read_samples(service: Service, block: BlockRecord) -> Samples:
    """(channels, count) samples, little-endian, exactly as the device delivered them.

    Raises:
        BlockDamagedError: they are not those that were recorded.
        StorageError: they cannot be read, or were deleted.
    """
    with open_samples(service.store.samples_file(block.run)) as reader:
        samples = reader.read(block.offset, block.count)
    require_intact(samples, block)
    return np.ascontiguousarray(samples, dtype=samples.dtype.newbyteorder("<"))


def judge_block(
    service: Service, run: str, n: int, verdict: BlockVerdict, lease: str | None, operator: str = "unknown"
) -> None:
    """Accept or reject a block of a run, going on or ended.

    One that has ended needs no lease, since nothing moves; `operator` is who judges then.

    Raises:
        NotFoundError: there is no such block.
        LeaseNeededError: the run goes on, and its rig's lease is another's.
        ConflictError: the run belongs to no campaign.
        PlanError: a block is accepted in a test that goes on and is no impact test.
    """
    block, record, entry = block_record(service, run, n), record_of(service, run), service.repository.run_entry(run)
    if entry is None:
        raise ConflictError(
            f"run {run} belongs to no campaign of this service", where=run, remedy="use the program that started it"
        )
    if record.state not in ENDED:
        service.leases.require(entry.rig, lease)
        _while_running(service, entry.rig, run, n, verdict, lease)
        return
    if block.note.accepted == verdict.accepted:
        return
    word = "accepted" if verdict.accepted else "rejected"
    service.store.catalogue.judge_block(
        run, n, accepted=verdict.accepted, reason=verdict.reason or word, operator=operator, utc=utc_now()
    )
    audit.enter_action(service.engine, operator, "verdict", f"{run}/{n}", verdict.model_dump())
    given = BlockJudged(run=run, n=n, operator=operator, accepted=verdict.accepted, reason=verdict.reason)
    service.log.append(given.kind, EventTopic(entry.rig, entry.campaign, run), given.model_dump())
    IdentificationAfterRun(service.store, service.jobs).block_judged(run)


def _while_running(service: Service, rig: str, run: str, n: int, verdict: BlockVerdict, lease: str | None) -> None:
    reason = verdict.reason
    if verdict.accepted:
        service.control.command(rig, run, AcceptHit(n=n, reason=reason or "accepted at the bench"), lease)
    else:
        service.control.command(rig, run, DropHit(n=n, reason=reason or "rejected by the operator"), lease)
