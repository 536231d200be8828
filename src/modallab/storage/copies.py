"""Copies for a backup or a restore: all rows of one database into another, and the samples of a run."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import h5py
from sqlalchemy import Connection, MetaData, Table, func, insert, inspect, select, text

from modallab.core.errors import StorageError
from modallab.storage.durable import storage_failure, sync_file, sync_folder
from modallab.storage.recorder import checksum
from modallab.storage.records import BlockRecord
from modallab.storage.samples import DATASET, open_h5, open_samples

BATCH = 500


def copy_tables(source: Connection, target: Connection, tables: Sequence[MetaData]) -> None:
    """Copy every row of every table that `source` has. `target` must have the tables, empty.

    Args:
        source: in a transaction that sees one moment of the database.
        target: in a transaction.
        tables: the descriptions of the tables.
    """
    known = set(inspect(source).get_table_names())
    for metadata in tables:
        for table in metadata.sorted_tables:
            if table.name in known:
                _copy_table(source, target, table)


def _copy_table(source: Connection, target: Connection, table: Table) -> None:
    # What an older program wrote may lack a column; then the new row has its default.
    known = {column["name"] for column in inspect(source).get_columns(table.name)}
    columns = [column for column in table.columns if column.name in known]
    rows = source.execution_options(yield_per=BATCH).execute(select(*columns)).mappings()
    for part in rows.partitions(BATCH):
        target.execute(insert(table), [{str(name): value for name, value in row.items()} for row in part])
    _go_on_counting(target, table)


def _go_on_counting(target: Connection, table: Table) -> None:
    # PostgreSQL's own counters know nothing of the numbers that came with the rows; SQLite's follow by themselves.
    column = table.autoincrement_column
    if target.dialect.name != "postgresql" or column is None or column.foreign_keys:
        return
    highest = target.scalar(select(func.max(column)))
    sequence = target.scalar(select(func.pg_get_serial_sequence(table.name, column.name)))
    if highest is not None and sequence is not None:
        target.execute(text("SELECT setval(:sequence, :highest)"), {"sequence": sequence, "highest": highest})


def copy_whole(source: Path, target: Path, blocks: Sequence[BlockRecord]) -> None:
    """Copy the file of a run that has ended, byte by byte, and check its blocks in the copy.

    Raises:
        StorageError: a block that is not what was recorded, or a copy that cannot be written.
    """
    try:
        shutil.copyfile(source, target)
    except OSError as error:
        raise storage_failure(error, str(target)) from error
    _check_blocks(target, blocks)
    _flush_to_disk(target)


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
        raise storage_failure(error, str(target)) from error
    _check_blocks(target, blocks)
    _flush_to_disk(target)


def _check_blocks(target: Path, blocks: Sequence[BlockRecord]) -> None:
    with open_samples(target) as reader:
        for block in blocks:
            found = checksum(reader.read(block.offset, block.count))
            if found != block.crc32:
                raise StorageError(
                    f"block {block.note.name} is not what was recorded: CRC-32 {found:08x}, {block.crc32:08x} expected",
                    where=str(target),
                    remedy="look at the disk of the original; an older backup may still hold it",
                )


def _flush_to_disk(target: Path) -> None:
    with target.open("rb+") as file:
        sync_file(file.fileno())
    sync_folder(target.parent)
