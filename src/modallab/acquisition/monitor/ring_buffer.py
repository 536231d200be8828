"""The last seconds of a run in memory that other processes can read: nothing is sent, so nobody is waited for.

One process writes, any number read. A reader knows what it may take by two counts in the header: samples written, and
samples that are being overwritten. It copies, then looks again whether what it took was overwritten meanwhile.
"""

import mmap
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

MAX_BYTES = 256 * 2**20
CELL = 256
"""Overload is kept for so many samples together."""

_HEADER = 4096
_PIECE = 2**20
_WRITTEN, _OVERWRITTEN = 0, 1
_MEMORY = Path("/dev/shm")


@dataclass(frozen=True, slots=True)
class RingBufferLayout:
    """How a ring is laid out.

    Attributes:
        channels: rows.
        capacity: samples per channel, a multiple of CELL.
        dtype: of the samples, as NumPy writes it.
    """

    channels: int
    capacity: int
    dtype: str

    @classmethod
    def of_duration(cls, channels: int, rate_hz: float, dtype: "np.dtype[Any]", seconds: float) -> Self:
        """For so many seconds, or fewer where that would take too much memory."""
        most = MAX_BYTES // (channels * dtype.itemsize)
        cells = max(4, min(round(seconds * rate_hz), most) // CELL)
        return cls(channels, cells * CELL, dtype.str)

    @property
    def sample_bytes(self) -> int:
        """Of all samples."""
        return self.channels * self.capacity * np.dtype(self.dtype).itemsize

    @property
    def file_bytes(self) -> int:
        """Of header, samples and overload."""
        return _HEADER + self.sample_bytes + self.channels * (self.capacity // CELL)


class RingBuffer:
    """The mapped memory, from either side."""

    def __init__(self, path: Path, shape: RingBufferLayout, *, write: bool = False) -> None:
        """Map a file of the right size.

        Raises:
            OSError: it is not there.
        """
        with path.open("r+b" if write else "rb") as file:
            access = mmap.ACCESS_WRITE if write else mmap.ACCESS_READ
            self._map = mmap.mmap(file.fileno(), shape.file_bytes, access=access)
        self.path, self.shape = path, shape
        self._counts: NDArray[np.int64] = np.frombuffer(self._map, np.int64, 2)
        count = shape.channels * shape.capacity
        samples = np.frombuffer(self._map, np.dtype(shape.dtype), count, _HEADER)
        over = np.frombuffer(self._map, np.uint8, count // CELL, _HEADER + shape.sample_bytes)
        self._samples: NDArray[Any] = samples.reshape(shape.channels, shape.capacity)
        self._over: NDArray[np.uint8] = over.reshape(shape.channels, shape.capacity // CELL)

    @property
    def samples_written(self) -> int:
        """Samples per channel since the ring was made."""
        return int(self._counts[_WRITTEN])

    @property
    def oldest_sample(self) -> int:
        """The first sample that is still there."""
        return max(0, int(self._counts[_OVERWRITTEN]) - self.shape.capacity)

    def write(self, samples: NDArray[Any], overload: NDArray[np.bool_]) -> None:
        """Append (channels, n) samples, n at most what fits, and (channels,) whether each was beyond its range."""
        capacity, first = self.shape.capacity, self.samples_written
        after, at = first + samples.shape[1], first % capacity
        # Before the samples: whoever copies what is about to go sees it afterwards.
        self._counts[_OVERWRITTEN] = after
        head = min(samples.shape[1], capacity - at)
        self._samples[:, at : at + head] = samples[:, :head]
        self._samples[:, : samples.shape[1] - head] = samples[:, head:]
        self._mark(first, after, overload)
        self._counts[_WRITTEN] = after

    def read(
        self, first: int, count: int, rows: "slice | list[int]" = slice(None)
    ) -> tuple[int, NDArray[Any], NDArray[np.bool_]]:
        """Up to `count` samples of some channels from number `first` on, or from the oldest that is there.

        Returns:
            number of the first one, (rows, n) samples, (rows, cells) whether each was beyond its range in the
            CELL samples of a cell; the first cell holds the first sample.
        """
        while True:
            start = max(first, self.oldest_sample)
            stop = max(start, min(start + count, self.samples_written))
            cells = np.arange(start // CELL, -(-stop // CELL)) % self._over.shape[1]
            samples, over = self._copy(start, stop, rows), self._over[rows][:, cells] != 0
            if self.oldest_sample <= start:
                return start, samples, over

    def _copy(self, start: int, stop: int, rows: "slice | list[int]") -> NDArray[Any]:
        at, capacity = start % self.shape.capacity, self.shape.capacity
        head = min(stop - start, capacity - at)
        chosen = self._samples[rows] if isinstance(rows, slice) else [self._samples[row] for row in rows]
        found = np.empty((len(chosen), stop - start), self._samples.dtype)
        for into, row in zip(found, chosen, strict=True):
            into[:head] = row[at : at + head]
            into[head:] = row[: stop - start - head]
        return found

    def _mark(self, first: int, after: int, overload: NDArray[np.bool_]) -> None:
        cells = np.arange(first // CELL, (after - 1) // CELL + 1)
        # A cell that is begun again forgets what was in it a round before.
        begun = cells[cells * CELL >= first] % self._over.shape[1]
        self._over[:, begun] = 0
        self._over[:, cells % self._over.shape[1]] |= overload[:, None].astype(np.uint8)

    def close(self) -> None:
        """Let go of the memory; where arrays of it are still in use, that happens with them."""
        del self._counts, self._samples, self._over
        try:
            self._map.close()
        except BufferError:
            return


def make_ring_buffer(shape: RingBufferLayout) -> RingBuffer:
    """A new one, in memory where the system has a folder for that.

    Raises:
        OSError: there is no room for it.
    """
    folder = _MEMORY if os.access(_MEMORY, os.W_OK) else Path(tempfile.gettempdir())
    descriptor, name = tempfile.mkstemp(".ring", f"modallab-{os.getpid()}-", folder)
    try:
        with os.fdopen(descriptor, "wb") as file:
            # Written, not only sized: memory that turns out to be missing later would end the process.
            for begin in range(0, shape.file_bytes, _PIECE):
                file.write(bytes(min(_PIECE, shape.file_bytes - begin)))
        return RingBuffer(Path(name), shape, write=True)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise
