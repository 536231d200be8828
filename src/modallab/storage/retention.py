"""Deletes samples that are no longer needed, and remembers that they were there."""

from collections.abc import Collection
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from modallab.core.errors import StorageError
from modallab.core.events import RunState
from modallab.storage.records import ENDED, RunRecord
from modallab.storage.store import Store


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
