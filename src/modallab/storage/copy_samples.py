"""Copies of a run's samples: the file itself once it is closed, its committed blocks while it is written."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import h5py

from modallab.core.errors import StorageError
from modallab.storage.durable import failure, sync_file, sync_folder
from modallab.storage.recorder import checksum
from modallab.storage.records import BlockRecord
from modallab.storage.samples import DATASET, open_h5, open_samples


def copy_whole(source: Path, target: Path, blocks: Sequence[BlockRecord]) -> None:
    """Copy the file of a run that has ended, byte by byte, and check its blocks in the copy.

    Raises:
        StorageError: a block that is not what was recorded, or a copy that cannot be written.
    """
    try:
        shutil.copyfile(source, target)
    except OSError as error:
        raise failure(error, str(target)) from error
    _check(target, blocks)
    _to_disk(target)


def copy_live(source: Path, target: Path, blocks: Sequence[BlockRecord]) -> None:
    """Copy the committed blocks of a run that is being recorded into a closed file of the same layout.

    The bytes of a file that is written would be of different moments; its blocks are read as any reader does.

    Raises:
        StorageError: as for `copy_whole`.
    """
    end = max((block.offset + block.count for block in blocks), default=0)
    try:
        with open_h5(source) as old, h5py.File(target, "x", libver="latest") as new:
            data = cast("h5py.Dataset", old[DATASET])
            shape = (data.shape[0], end)
            copy = new.create_dataset(DATASET, shape, data.dtype, maxshape=(data.shape[0], None), chunks=data.chunks)
            for name, value in old.attrs.items():
                new.attrs[name] = value
            for block in blocks:
                place = slice(block.offset, block.offset + block.count)
                copy[:, place] = data[:, place]
    except (OSError, RuntimeError) as error:
        raise failure(error, str(target)) from error
    _check(target, blocks)
    _to_disk(target)


def _check(target: Path, blocks: Sequence[BlockRecord]) -> None:
    with open_samples(target) as reader:
        for block in blocks:
            found = checksum(reader.read(block.offset, block.count))
            if found != block.crc32:
                raise StorageError(
                    f"block {block.note.name} is not what was recorded: CRC-32 {found:08x}, {block.crc32:08x} expected",
                    where=str(target),
                    remedy="look at the disk of the original; an older backup may still hold it",
                )


def _to_disk(target: Path) -> None:
    with target.open("rb+") as file:
        sync_file(file.fileno())
    sync_folder(target.parent)
