"""The file of a run's samples: one resizable dataset in an HDF5 file that survives the death of its writer.

HDF5 marks a file while it is written. A marked file opens in the mode for live files only, and in that mode a damaged
spot is not an error but read again and again for ever, in the hope that a writer is about to finish it. The mark and
the end of the file stand in the superblock (HDF5 File Format Specification 3.0, II.A, version 3), with a checksum.
"""

import os
import re
import struct
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import StorageError
from modallab.storage.durable import require_space, storage_failure, sync_file, sync_folder

DATASET = "samples"
RESERVE_BLOCKS = 4
RESERVE_BYTES = 1 << 20

Samples = NDArray[Any]

_ABANDONED: list[tuple[h5py.File, h5py.Dataset]] = []
"""Files HDF5 could not write. It crashes the process on closing such a file, so they are never closed."""


class SampleWriter:
    """Appends blocks; what `append` has returned for is on the disk and survives a kill and a power cut."""

    def __init__(
        self, path: Path, shape: tuple[int, int], dtype: np.dtype[np.generic], attributes: dict[str, Any]
    ) -> None:
        """Make the file at `path`, which must not exist, for blocks of `shape` (channels, samples).

        Raises:
            DiskFullError: there is no room for the reserve and a few blocks.
            StorageError: it cannot be made.
        """
        self._path = path
        self._end = 0
        self._broken = False
        self._descriptor = -1
        self._block_bytes = int(np.prod(shape)) * dtype.itemsize
        self._reserve = path.with_suffix(".reserve")
        try:
            self._take_reserve()
            self._file, self._data = _create_file(path, shape, dtype, attributes)
            self._descriptor = os.open(path, os.O_RDWR | getattr(os, "O_BINARY", 0))
            sync_file(self._descriptor)
            sync_folder(path.parent)
        except (OSError, RuntimeError) as error:
            raise storage_failure(error, str(path)) from error

    @property
    def dtype(self) -> np.dtype[np.generic]:
        """Type of the samples in the file, little-endian."""
        return self._data.dtype

    @property
    def left_unusable_file(self) -> bool:
        """Whether a failed write has left a file that may only be left behind."""
        return self._broken

    def append(self, samples: Samples) -> int:
        """Write (channels, n) samples and wait until they are on the disk; returns their offset in the dataset.

        Raises:
            DiskFullError, StorageError: the block was not kept; all before it are.
        """
        if self._broken:
            raise StorageError("an earlier write failed", where=str(self._path), remedy="continue with a new run")
        require_space(self._path.parent, RESERVE_BLOCKS * self._block_bytes)
        offset, end = self._end, self._end + samples.shape[1]
        try:
            self._data.resize(end, axis=1)
            self._data[:, offset:end] = samples
            self._data.flush()
            sync_file(self._descriptor)
        except (OSError, RuntimeError) as error:
            self._give_up()
            raise storage_failure(error, str(self._path)) from error
        self._end = end
        return offset

    def close(self) -> None:
        """Close the file, so that it opens without SWMR too."""
        if self._descriptor < 0:
            return
        if not self._broken:
            try:
                self._file.close()
                sync_file(self._descriptor)
            except (OSError, RuntimeError) as error:
                _ABANDONED.append((self._file, self._data))
                raise storage_failure(error, str(self._path)) from error
        os.close(self._descriptor)
        self._descriptor = -1
        self.free_reserve()

    def _take_reserve(self) -> None:
        # Bytes that no file system can compress or leave out, kept to let HDF5 finish its file on a full disk.
        size = max(RESERVE_BYTES, RESERVE_BLOCKS * self._block_bytes)
        require_space(self._path.parent, 2 * size)
        with self._reserve.open("wb") as file:
            file.write(os.urandom(size))
            file.flush()
            os.fsync(file.fileno())

    def free_reserve(self) -> None:
        """Give the reserve's room to whatever must still be written."""
        self._reserve.unlink(missing_ok=True)

    def _give_up(self) -> None:
        self._broken = True
        self.free_reserve()
        try:
            self._data.flush()
            self._file.close()
        except (OSError, RuntimeError):
            _ABANDONED.append((self._file, self._data))


def _create_file(
    path: Path, shape: tuple[int, int], dtype: np.dtype[np.generic], attributes: dict[str, Any]
) -> tuple[h5py.File, h5py.Dataset]:
    file = h5py.File(path, "x", libver="latest")
    # A chunk of one block: a block is then written once and whole.
    data = file.create_dataset(
        DATASET,
        shape=(shape[0], 0),
        maxshape=(shape[0], None),
        chunks=shape,
        dtype=dtype.newbyteorder("<"),
    )
    for name, value in attributes.items():
        file.attrs[name] = value
    file.flush()
    file.swmr_mode = True
    return file, data


class SampleReader:
    """The samples of one run, also while it is being recorded and after its writer was killed."""

    def __init__(self, path: Path, data: h5py.Dataset) -> None:
        self._path = path
        self._data = data

    def read(self, offset: int, count: int) -> Samples:
        """(channels, count) samples from `offset`.

        Raises:
            StorageError: the file ends before, or cannot be read there.
        """
        try:
            samples: Samples = self._data[:, offset : offset + count]
        except (OSError, RuntimeError) as error:
            raise _unreadable_error(self._path, error) from error
        if samples.shape[1] != count:
            raise StorageError(
                f"samples {offset} to {offset + count} are not in the file, which ends at {self._data.shape[1]}",
                where=str(self._path),
                remedy="restore the file from a copy",
            )
        return samples


@contextmanager
def open_samples(path: Path) -> Generator[SampleReader]:
    """Open a run's samples for reading.

    Raises:
        StorageError: there is no such file, or it is not whole.
    """
    try:
        file = open_h5(path)
    except (OSError, RuntimeError) as error:
        raise _unreadable_error(path, error) from error
    with file:
        try:
            data = cast("h5py.Dataset", file[DATASET])
        except (KeyError, OSError, RuntimeError) as error:
            raise _unreadable_error(path, error) from error
        yield SampleReader(path, data)


def open_h5(path: Path) -> h5py.File:
    """The file of a run, closed or being written, for reading."""
    try:
        return h5py.File(path, "r")
    except OSError as error:
        if "already open" not in str(error):
            raise
    # Only for a file that is being written: in this mode HDF5 reads a damaged spot again and again for ever.
    return h5py.File(path, "r", libver="latest", swmr=True)


def _unreadable_error(path: Path, error: Exception) -> StorageError:
    said = re.sub(r"\s+", " ", str(error))
    return StorageError(f"cannot be read: {said}", where=str(path), remedy="restore the file from a copy")


SIGNATURE = b"\x89HDF\r\n\x1a\n"
_SIZE, _VERSION, _FLAGS = 48, 8, 11
_END = slice(28, 36)
_SUM = slice(44, 48)
_MASK = 0xFFFFFFFF


def seal_file(path: Path) -> bool:
    """Take the mark off a file nobody writes any more; samples are not touched. False if it is not such a file."""
    with path.open("r+b") as file:
        head = bytearray(file.read(_SIZE))
        if not _is_sound(head):
            return False
        head[_FLAGS] = 0
        head[_END] = struct.pack("<Q", os.fstat(file.fileno()).st_size)
        head[_SUM] = struct.pack("<I", lookup3_checksum(bytes(head[: _SUM.start])))
        file.seek(0)
        file.write(head)
        file.flush()
        sync_file(file.fileno())
    return True


def _is_sound(head: bytearray) -> bool:
    if len(head) < _SIZE or not head.startswith(SIGNATURE) or head[_VERSION] != 3:
        return False
    return struct.unpack("<I", head[_SUM])[0] == lookup3_checksum(bytes(head[: _SUM.start]))


def lookup3_checksum(data: bytes) -> int:
    """Checksum of HDF5's metadata: Bob Jenkins' lookup3, `hashlittle` with an initial value of 0."""
    a = b = c = (0xDEADBEEF + len(data)) & _MASK
    if not data:
        return c
    padded = data + bytes(-len(data) % 12)
    words = struct.unpack(f"<{len(padded) // 4}I", padded)
    for n in range(0, len(words), 3):
        a, b, c = (a + words[n]) & _MASK, (b + words[n + 1]) & _MASK, (c + words[n + 2]) & _MASK
        a, b, c = _mix_words(a, b, c) if n + 3 < len(words) else _final_mix(a, b, c)
    return c


def _mix_words(a: int, b: int, c: int) -> tuple[int, int, int]:
    for turn in (4, 6, 8, 16, 19, 4):
        a = ((a - c) & _MASK) ^ _rotate_left(c, turn)
        c = (c + b) & _MASK
        a, b, c = b, c, a
    return a, b, c


def _final_mix(a: int, b: int, c: int) -> tuple[int, int, int]:
    for turn in (14, 11, 25, 16, 4, 14, 24):
        c = ((c ^ b) - _rotate_left(b, turn)) & _MASK
        a, b, c = b, c, a
    # Seven steps are two rounds and one: the three stand one place further.
    return c, a, b


def _rotate_left(value: int, bits: int) -> int:
    return ((value << bits) | (value >> (32 - bits))) & _MASK
