"""Records one run: samples to the disk, then the row, and only then the acknowledgement."""

import time
import zlib
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime
from math import isfinite
from pathlib import Path
from typing import Any, Self

import numpy as np

from modallab.bench.protocol import DeliveredSampling
from modallab.core.child_process import FileLock
from modallab.core.errors import DiskFullError, StorageError
from modallab.core.events import BlockAcknowledged, RunState
from modallab.core.versions import SAMPLES
from modallab.storage.catalogue import RunCatalogue
from modallab.storage.durable import require_room
from modallab.storage.records import ENDED, BlockNote, BlockRecord, RunRecord
from modallab.storage.samples import Samples, SampleWriter


def utc_now() -> str:
    """The time for people, ISO 8601 to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def checksum(samples: Samples) -> int:
    """CRC-32 of (channels, n) samples as they stand in the file: C order, little-endian."""
    return zlib.crc32(np.ascontiguousarray(samples, dtype=samples.dtype.newbyteorder("<")).data)


@dataclass(frozen=True, slots=True)
class SamplesInFile:
    """Where samples are on the disk.

    Attributes:
        offset: in the dataset.
        count: samples per channel.
        crc32: their checksum.
    """

    offset: int
    count: int
    crc32: int


def _place_samples(writer: SampleWriter, samples: Samples) -> SamplesInFile:
    crc32 = checksum(samples)
    return SamplesInFile(writer.append(samples), int(samples.shape[1]), crc32)


class Recorder:
    """The one writer of a run. As a context manager it lets go of the lease and the file however the run ends."""

    def __init__(self, catalogue: RunCatalogue, folder: Path, run: RunRecord, lease: FileLock) -> None:
        self.run = run.id
        self._record = run
        self._catalogue = catalogue
        self._path = folder / f"{run.id}.h5"
        self._lease = lease
        self._writer: SampleWriter | None = None
        self._hand = ThreadPoolExecutor(1, "samples")
        self._n = 0

    @property
    def left_unusable_file(self) -> bool:
        """Whether a failed write left a file that HDF5 cannot close: the process should end without its clean-up."""
        return self._writer is not None and self._writer.left_unusable_file

    def open(self, delivery: DeliveredSampling, block_samples: int) -> None:
        """Make the file for what the configured device will deliver.

        Raises:
            DiskFullError, StorageError: it cannot be made.
        """
        shape = (len(delivery.units), block_samples)
        require_room(self._path.parent, self._record.plan, shape[0] * shape[1] * delivery.dtype.itemsize)
        self._writer = SampleWriter(self._path, shape, delivery.dtype, self._attributes(delivery))
        self._catalogue.update_run(
            self.run,
            requested_rate_hz=delivery.requested_rate_hz,
            actual_rate_hz=delivery.actual_rate_hz,
            rate_hz=delivery.rate_hz,
            dtype=self._writer.dtype.str,
            scale=[float(value) for value in delivery.scale],
            units=list(delivery.units),
        )

    def enter_state(self, state: RunState, reason: str = "", *, valid: bool = True) -> None:
        """Commit the run's state; on a full disk in the room that was kept for it.

        Raises:
            DiskFullError, StorageError: it was not committed.
        """
        ended = {"ended_utc": utc_now()} if state in ENDED else {}
        row = {"state": state, "reason": reason, "valid": valid, **ended}
        try:
            self._catalogue.update_run(self.run, **row)
        except DiskFullError:
            if self._writer is None:
                raise
            self._writer.free_reserve()
            self._catalogue.update_run(self.run, **row)

    def record_block(self, samples: Samples, note: BlockNote) -> BlockAcknowledged:
        """Keep (channels, n) samples for good; when this returns, no crash can lose them.

        Raises:
            DiskFullError, StorageError: not kept; all blocks before are.
        """
        return self.keep_block(self.place_block(samples), note)

    def place_block(self, samples: Samples) -> Future[SamplesInFile]:
        """Begin to write (channels, n) samples, which must not change; until `keep` they are no block.

        Raises:
            StorageError: no file is open.
        """
        if self._writer is None:
            raise StorageError("no file is open", where=self.run, remedy="call open with the delivery first")
        return self._hand.submit(_place_samples, self._writer, samples)

    def keep_block(self, placed: Future[SamplesInFile], note: BlockNote) -> BlockAcknowledged:
        """Wait until placed samples are on the disk, and keep them as a block; raises as `record`."""
        at = placed.result()
        assert self._writer is not None
        block = BlockRecord(
            run=self.run,
            n=self._n,
            offset=at.offset,
            count=at.count,
            crc32=at.crc32,
            monotonic_s=time.monotonic(),
            utc=utc_now(),
            note=note,
        )
        try:
            self._catalogue.add_block(block)
        except DiskFullError:
            # The row of the run's end must still find room.
            self._writer.free_reserve()
            raise
        self._n += 1
        return _acknowledge_block(block)

    def drop_block(self, name: str, reason: str) -> bool:
        """Say that the block of this name no longer counts; whether there was one that did."""
        return drop_block(self._catalogue, self.run, name, reason)

    def accept_block(self, name: str, reason: str, operator: str) -> bool:
        """Say that the rejected block of this name counts, by the operator's word; whether there was one."""
        found = [row for row in self._catalogue.blocks(self.run) if row.note.name == name and not row.note.accepted]
        for row in found:
            self._catalogue.judge_block(self.run, row.n, accepted=True, reason=reason, operator=operator, utc=utc_now())
        return bool(found)

    def close_file(self) -> None:
        """Close the file: no more blocks."""
        self._hand.shutdown()
        if self._writer is not None:
            self._writer.close()

    def close(self) -> None:
        """Close the file and let go of the run."""
        try:
            self.close_file()
        finally:
            self._lease.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _attributes(self, delivery: DeliveredSampling) -> dict[str, Any]:
        # The file explains itself without the catalogue.
        run = self._record
        return {
            "format_version": SAMPLES,
            "run": run.id,
            "test": run.test,
            "plan": run.plan.model_dump_json(),
            "rig": run.rig.model_dump_json(),
            "rig_hash": run.rig_hash,
            "bench_url": run.bench_url,
            "code_version": run.code_version,
            "created_utc": run.created_utc,
            "requested_rate_hz": delivery.requested_rate_hz,
            "actual_rate_hz": delivery.actual_rate_hz,
            "rate_hz": delivery.rate_hz,
            "scale": delivery.scale,
            "units": list(delivery.units),
            "channels": [channel.name for channel in run.rig.channels],
        }


def _acknowledge_block(block: BlockRecord) -> BlockAcknowledged:
    facts = {name: value for name, value in block.note.facts.items() if not _unknown_block(value)}
    return BlockAcknowledged.of_fields(block, block.note, facts=facts)


def _unknown_block(value: float | str) -> bool:
    # JSON has no NaN, and a number that is not known says nothing.
    return isinstance(value, float) and not isfinite(value)


def drop_block(catalogue: RunCatalogue, run: str, name: str, reason: str) -> bool:
    """Mark the accepted block `name` of a run as dropped, running or ended; whether there was one."""
    found = [row for row in catalogue.blocks(run) if row.note.name == name and row.note.accepted]
    for row in found:
        catalogue.drop_block(run, row.n, reason, utc_now())
    return bool(found)
