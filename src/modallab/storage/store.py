"""A data folder: its catalogue, its sample files, and what is read back from them."""

import hashlib
import json
import secrets
from collections.abc import Collection, Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Self, TypedDict

import numpy as np

from modallab import __version__
from modallab.bench.protocol import BenchInfo
from modallab.bench.resampling import ResamplingRule
from modallab.core.block import Block, Ramp, other_driven_points
from modallab.core.child_process import FileLock
from modallab.core.errors import BlockDamagedError, StorageError
from modallab.core.plan import Plan, SinePlan, test_of_plan
from modallab.core.rig import Rig
from modallab.storage.catalogue import RunCatalogue
from modallab.storage.durable import require_local
from modallab.storage.engine import database_of
from modallab.storage.recorder import Recorder, checksum, drop_block, utc_now
from modallab.storage.records import ENDED, BlockNote, BlockRecord, RunRecord
from modallab.storage.samples import SampleReader, Samples, open_samples, seal_file

INTERRUPTED = "interrupted"


class Store:
    """Runs and blocks under one folder: `modallab.db` and `runs/<run>.h5`. Any number of readers, one writer a run.

    The catalogue is on a PostgreSQL server instead if the folder has a file `database.url` with its address.
    """

    def __init__(self, folder: Path) -> None:
        """Open a data folder, and make it if it is not there.

        Raises:
            StorageError: it is on a network share, or cannot be written.
            FormatError: it is of a version this program does not know.
        """
        self.folder = folder
        self._runs = folder / "runs"
        try:
            self._runs.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StorageError(
                f"cannot be made: {error.strerror}", where=str(folder), remedy="choose another data folder"
            ) from error
        require_local(folder)
        self.catalogue = RunCatalogue(database_of(folder))

    def begin(self, plan: Plan, rig: Rig, bench: BenchInfo) -> Recorder:
        """Enter a new run in the catalogue and lease it to this process."""
        now = datetime.now(UTC)
        run = RunRecord(
            id=f"{now:%Y%m%dT%H%M%S.%f}"[:19].replace(".", "-") + f"-{plan.kind}-{secrets.token_hex(2)}",
            test=test_of_plan(plan),
            state="created",
            reason="",
            valid=True,
            plan=plan,
            rig=rig,
            rig_hash=rig_hash(rig),
            bench_url=bench.url,
            facts=_facts_of_bench(bench),
            code_version=__version__,
            created_utc=utc_now(),
            ended_utc="",
            rates=None,
            dtype="",
            scale=(),
            units=(),
        )
        lease = self._lease(run.id)
        lease.acquire()
        self.catalogue.add_run(run)
        return Recorder(self.catalogue, self._runs, run, lease)

    def recover(self) -> tuple[str, ...]:
        """Mark every active run whose recorder is dead as failed (interrupted); returns their names.

        Its committed blocks stay readable. A run another live process records is left alone.
        """
        return tuple(run for run in self.catalogue.runs_without_end() if self._bury(run))

    def _bury(self, run: str) -> bool:
        with self._lease(run) as lease:
            # The run may have ended between the look at its row and the lease.
            if not lease.acquire() or self.catalogue.run(run).state in ENDED:
                return False
            self.catalogue.update_run(run, state="failed", reason=INTERRUPTED, ended_utc=utc_now())
            (self._runs / f"{run}.reserve").unlink(missing_ok=True)
            file = self._runs / f"{run}.h5"
            if file.exists():
                seal_file(file)
            return True

    def blocks(self, run: str, *, rejected: bool = False) -> tuple[Block, ...]:
        """The accepted blocks of a run, in the order of time, checked against their CRC; with `rejected`, all of them.

        Raises:
            StorageError: no such run, or a block that is not what was acknowledged, by name.
        """
        return tuple(self.iterate_blocks(run, rejected=rejected))

    def iterate_blocks(
        self, run: str, *, rejected: bool = False, numbers: Collection[int] | None = None
    ) -> Iterator[Block]:
        """As `blocks`, one after the other; with `numbers` only those."""
        record = self.catalogue.run(run)
        rows = self.catalogue.blocks(run)
        chosen = [row for row in rows if (rejected or row.note.accepted) and (numbers is None or row.n in numbers)]
        if not chosen:
            return
        with open_samples(self.samples_file(run)) as reader:
            for row in chosen:
                yield _block_of_run(record, row, reader)

    def block(self, run: str, name: str) -> Block:
        """One block of a run by its name, whether it counts or not, while the run goes on or after.

        Raises:
            StorageError: no such run or block, or one that is not what was acknowledged.
        """
        record = self.catalogue.run(run)
        rows = [row for row in self.catalogue.blocks(run) if row.note.name == name]
        if not rows:
            raise StorageError(f"there is no block {name!r} in run {run}", where=str(self.folder), remedy="list them")
        with open_samples(self.samples_file(run)) as reader:
            return _block_of_run(record, rows[-1], reader)

    def revision(self, runs: Sequence[str]) -> str:
        """SHA-256 of what decides what is computed of runs: each one's rig, and its blocks with whether they count.

        Raises:
            StorageError: no such run.
        """
        held = [
            (run, self.catalogue.run(run).rig_hash, [(row.n, row.crc32, row.note.accepted) for row in rows])
            for run, rows in ((run, self.catalogue.blocks(run)) for run in runs)
        ]
        return hashlib.sha256(json.dumps(held).encode()).hexdigest()

    def drop_block(self, run: str, block: str, reason: str = "dropped by the operator") -> None:
        """Leave one accepted block of a run out from now on; its samples stay, and `rejected` still reads them.

        Raises:
            StorageError: no such run, or no block of this name that counts.
        """
        self.catalogue.run(run)
        if not drop_block(self.catalogue, run, block, reason):
            counted = [row.note.name for row in self.catalogue.blocks(run) if row.note.accepted]
            raise StorageError(
                f"run {run} has no valid block {block!r}",
                where=str(self.folder),
                remedy=f"name one of: {', '.join(counted) or 'none'}",
            )

    def samples_file(self, run: str) -> Path:
        """Where the samples of a run are.

        Raises:
            StorageError: they were deleted.
        """
        file = self._runs / f"{run}.h5"
        removed = None if file.exists() else self.catalogue.runs_without_samples().get(run)
        if removed is not None:
            raise StorageError(
                f"the samples of run {run} were deleted ({removed})", where=str(file), remedy="restore a backup"
            )
        return file

    def close(self) -> None:
        """Let go of the catalogue."""
        self.catalogue.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _lease(self, run: str) -> FileLock:
        return FileLock(self._runs / f"{run}.lease")


def rig_hash(rig: Rig) -> str:
    """SHA-256 of a rig's JSON: the revision of the bench as believed."""
    return hashlib.sha256(rig.model_dump_json().encode()).hexdigest()


def _facts_of_bench(bench: BenchInfo) -> dict[str, str]:
    devices = {f"device {n}": f"{name}, serial {serial}" for n, (name, serial) in enumerate(bench.devices)}
    return devices | bench.facts


def _block_of_run(run: RunRecord, row: BlockRecord, reader: SampleReader) -> Block:
    samples = reader.read(row.offset, row.count)
    require_intact(samples, row)
    assert run.rates is not None  # a block is recorded after the delivery is known
    recut = ResamplingRule.read(row.note.facts)
    over = set(row.note.overload)
    return Block(
        name=row.note.name,
        test=row.note.test,
        order=row.n,
        rate_hz=run.rates.delivered_hz,
        samples=samples if recut is None else recut.apply(samples),
        scale=np.array(run.scale),
        units=run.units,
        channels=tuple(channel.name for channel in run.rig.channels),
        drive_point=row.note.drive_point,
        level=row.note.level,
        frequency_hz=row.note.frequency_hz,
        first_sample=row.note.first_sample,
        requested_rate_hz=run.rates.requested_hz,
        actual_rate_hz=run.rates.actual_hz,
        overload=tuple(channel.name in over for channel in run.rig.channels),
        also_driven=other_driven_points(row.note.facts),
        **_rise_of_sine(run, row.note, run.rates.delivered_hz if recut is None else recut.from_hz),
    )


def require_intact(samples: Samples, row: BlockRecord) -> None:
    """Reject samples that are not those a block was acknowledged with.

    Raises:
        BlockDamagedError: their CRC-32 is another.
    """
    found = checksum(samples)
    if found != row.crc32:
        raise BlockDamagedError(
            f"the samples on the disk differ from the recording: CRC-32 {found:08x}, {row.crc32:08x} expected",
            where=f"run {row.run}, block {row.n}, {row.note.name}",
            remedy="restore the run's file from a copy, or leave this block out",
        )


class _RiseOfSine(TypedDict, total=False):
    history_s: float
    ramp_s: float
    ramp: Ramp


def _rise_of_sine(run: RunRecord, note: BlockNote, rate_hz: float) -> _RiseOfSine:
    """How the sine of a block came about: drivers raise every burst along a cosine, and say where it began."""
    began = note.facts.get("burst_first_sample")
    if not isinstance(run.plan, SinePlan) or not isinstance(began, float):
        return {}
    return {"history_s": (note.first_sample - began) / rate_hz, "ramp_s": run.plan.ramp_s, "ramp": "cosine"}
