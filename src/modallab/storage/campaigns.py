"""Several runs of one session at the bench, as one campaign."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

from modallab.core.block import Block, Campaign
from modallab.core.errors import StorageError
from modallab.core.events import RunState
from modallab.core.plan import ImpactPlan
from modallab.storage.records import ENDED, RunRecord
from modallab.storage.store import Store


def campaign_of(store: Store, runs: Sequence[str]) -> Campaign:
    """The accepted blocks of `runs`, in that order, with where they come from.

    Args:
        store: the data folder.
        runs: names of runs on one and the same rig.

    Raises:
        StorageError: no run, an aborted one, or runs on different rigs; a block that is not what was recorded.
    """
    records = [store.catalogue.run(run) for run in runs]
    _check_records(records, str(store.folder))
    blocks: list[Block] = []
    taken: set[str] = set()
    for number, record in enumerate(records, start=1):
        for block in store.iterate_blocks(record.id):
            # Two impact runs both begin with hit 1.
            name = block.name if block.name not in taken else f"{block.name}_run{number}"
            taken.add(name)
            blocks.append(replace(block, name=name, order=len(blocks)))
    return Campaign(
        rig=records[0].rig,
        blocks=tuple(blocks),
        provenance=_provenance(store, records),
        source=str(store.folder),
    )


def campaigns_by_rig(store: Store, runs: Sequence[str]) -> tuple[Campaign, ...]:
    """What runs have recorded, a campaign for each rig they were on, in the order of time.

    Raises:
        StorageError: as `campaign_of`.
    """
    records = [store.catalogue.run(run) for run in runs]
    rigs = [r.rig for n, r in enumerate(records) if r.rig not in [before.rig for before in records[:n]]]
    return tuple(campaign_of(store, [r.id for r in records if r.rig == rig]) for rig in rigs)


def rejected_blocks(store: Store, run: str) -> list[tuple[Block, str]]:
    """The blocks of a run that were not accepted, each with its reason."""
    reasons = {row.note.name: row.note.reason for row in store.catalogue.blocks(run) if not row.note.accepted}
    return [(block, reasons[block.name]) for block in store.iterate_blocks(run, rejected=True) if block.name in reasons]


def _check_records(records: Sequence[RunRecord], where: str) -> None:
    if not records:
        raise StorageError("no runs were given", where=where, remedy="name at least one run")
    # By the rigs themselves: the hash of the same rig may have been taken by an earlier version.
    if any(record.rig != records[0].rig for record in records):
        rigs = ", ".join(f"{record.id}: {record.rig_hash[:12]}" for record in records)
        raise StorageError(
            f"the runs are of different rigs ({rigs})", where=where, remedy="take runs of one rig revision only"
        )
    aborted = [record.id for record in records if not record.valid]
    if aborted:
        raise StorageError(
            f"aborted and therefore invalid: {', '.join(aborted)}", where=where, remedy="leave these runs out"
        )


def _provenance(store: Store, records: Sequence[RunRecord]) -> dict[str, str]:
    first = records[0]
    known = {
        "runs": " ".join(record.id for record in records),
        "bench": first.bench_url,
        "rig_hash": first.rig_hash,
        "code_version": " ".join(sorted({record.code_version for record in records})),
    }
    setups = [r.plan.setups[0].name for r in records if isinstance(r.plan, ImpactPlan) and r.plan.setups]
    setups += [record.facts["setup"] for record in records if "setup" in record.facts]
    known |= {"setup": setups[0]} if setups else {}
    for record in records:
        # Facts are the same in every run of one bench; where one differs, the later run's stands under its own name.
        for key, value in record.facts.items():
            if known.setdefault(f"bench.{key}", value) != value:
                known[f"{record.id}.bench.{key}"] = value
        known |= {f"{record.id}.{key}": value for key, value in _record_of_run(store, record).items()}
    return known


def _record_of_run(store: Store, record: RunRecord) -> dict[str, str]:
    rows = store.catalogue.blocks(record.id)
    rates = record.rates
    facts = {
        "state": record.state,
        "reason": record.reason,
        "created_utc": record.created_utc,
        "plan": record.plan.model_dump_json(),
        "requested_rate_hz": "" if rates is None else repr(rates.requested_hz),
        "actual_rate_hz": "" if rates is None else repr(rates.actual_hz),
        "rate_hz": "" if rates is None else repr(rates.delivered_hz),
        "rejected": "; ".join(f"{row.note.name}: {row.note.reason}" for row in rows if not row.note.accepted),
        "overload": "; ".join(f"{row.note.name}: {' '.join(row.note.overload)}" for row in rows if row.note.overload),
    }
    return {key: value for key, value in facts.items() if value}


@dataclass(frozen=True, slots=True)
class RetentionRule:
    """Which runs may go. What is asked for must hold all together.

    Attributes:
        older_than: since the run's end.
        states: only runs that ended so.
        also_valid: whether runs whose data are valid may go too. Not by themselves: they are what was measured.
    """

    older_than: timedelta = timedelta(0)
    states: Collection[RunState] = ("failed", "aborted")
    also_valid: bool = False

    def covers(self, run: RunRecord, now: datetime) -> bool:
        """Whether a run may go. One that goes on never may."""
        if run.state not in ENDED or run.state not in self.states:
            return False
        if run.valid and not self.also_valid:
            return False
        return now - datetime.fromisoformat(run.ended_utc or run.created_utc) >= self.older_than


@dataclass(frozen=True, slots=True)
class RemovableRun:
    """A run that a rule covers, and the bytes its samples take."""

    run: RunRecord
    size: int


def find_removable(store: Store, rule: RetentionRule, now: datetime | None = None) -> tuple[RemovableRun, ...]:
    """Runs that a rule covers, oldest first; those without samples are left out. Nothing is changed.

    Raises:
        StorageError: the rule names a state in which runs still go on.
    """
    active = sorted(set(rule.states) - ENDED)
    if active:
        raise StorageError(
            f"runs that are {', '.join(active)} are active", where="states", remedy="name done, failed or aborted"
        )
    moment = now or datetime.now(UTC)
    found = (run for run in store.catalogue.runs() if rule.covers(run, moment))
    files = ((run, store.folder / "runs" / f"{run.id}.h5") for run in found)
    return tuple(RemovableRun(run, file.stat().st_size) for run, file in files if file.exists())


def remove_samples(store: Store, runs: Collection[RemovableRun], reason: str) -> int:
    """Delete the samples of runs, and commit before that they are gone; returns the bytes that are free now."""
    for item in runs:
        store.catalogue.remove_samples(item.run.id, reason, item.size)
        (store.folder / "runs" / f"{item.run.id}.h5").unlink(missing_ok=True)
    return sum(item.size for item in runs)
