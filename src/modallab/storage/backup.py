"""A whole and consistent copy of a data folder, also while a run is being recorded, and the way back."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import h5py
from sqlalchemy import Connection, MetaData, Table, func, insert, inspect, select, text

from modallab.core.errors import StorageError
from modallab.storage.catalogue import RunCatalogue
from modallab.storage.durable import require_space, storage_failure, sync_file, sync_folder
from modallab.storage.engine import database_of, name_database
from modallab.storage.recorder import checksum
from modallab.storage.records import ENDED, BlockRecord
from modallab.storage.samples import DATASET, open_h5, open_samples
from modallab.storage.service_tables import METADATA
from modallab.storage.store import Store

RESULTS = "results"
_BATCH = 500


@dataclass(frozen=True, slots=True)
class CopiedData:
    """What a backup holds: runs, blocks and bytes of samples."""

    runs: int
    blocks: int
    sample_bytes: int


def back_up(store: Store, out: Path, also: Sequence[MetaData] = ()) -> CopiedData:
    """Copy a data folder to a new folder, which is a data folder itself, with its catalogue in SQLite.

    The catalogue is copied first, as it was at one moment; a block's samples were on the disk before its row, so
    all samples of that moment can be copied afterwards, however many come meanwhile. Every block is checked
    against its CRC.

    Args:
        store: what to copy; it may go on recording.
        out: a folder that is not there, or empty.
        also: descriptions of tables that others keep in the same database.

    Raises:
        StorageError: `out` is not empty; a block that is not what was recorded.
        DiskFullError: there is no room.
    """
    _require_empty(out)
    out.mkdir(parents=True, exist_ok=True)
    require_space(out, _size_of_folder(store.folder))
    catalogue = RunCatalogue(database_of(out))
    try:
        _copy_catalogue(store.catalogue, catalogue, also)
        copied = _copy_samples(store, catalogue, out)
    finally:
        catalogue.close()
    if (store.folder / RESULTS).is_dir():
        shutil.copytree(store.folder / RESULTS, out / RESULTS)
    return copied


def restore_backup(backup: Path, out: Path, database: str | None = None, also: Sequence[MetaData] = ()) -> CopiedData:
    """Make a data folder of a backup.

    Args:
        backup: what `back_up` wrote.
        out: a folder that is not there, or empty.
        database: address of an empty PostgreSQL database for the catalogue; None for SQLite in the folder.
        also: as for the backup.

    Raises:
        StorageError: `out` or the database is not empty, or the backup is damaged.
    """
    _require_empty(out)
    if not (backup / "runs").is_dir():
        raise StorageError("is no data folder", where=str(backup), remedy="name a folder that modallab backup wrote")
    if database is not None:
        name_database(out, database)
    with Store(backup) as source, Store(out) as target:
        if target.catalogue.runs():
            raise StorageError(
                "the database has runs already", where=target.catalogue.where, remedy="name an empty database"
            )
        _copy_catalogue(source.catalogue, target.catalogue, also)
        copied = _copy_samples(source, target.catalogue, out)
        target.recover()
    if (backup / RESULTS).is_dir():
        shutil.copytree(backup / RESULTS, out / RESULTS)
    return copied


def _copy_catalogue(source: RunCatalogue, target: RunCatalogue, also: Sequence[MetaData]) -> None:
    tables = [METADATA, *also]
    moment = source.engine.connect().execution_options(reading=True)
    if moment.dialect.name == "postgresql":
        moment = moment.execution_options(isolation_level="REPEATABLE READ")
    with moment as reading, target.engine.begin() as writing:
        for metadata in tables:
            metadata.create_all(writing)
        writing.execute(METADATA.tables["store"].delete())
        _copy_tables(reading, writing, tables)


def _copy_samples(store: Store, catalogue: RunCatalogue, out: Path) -> CopiedData:
    runs, blocks, size = catalogue.runs(), 0, 0
    (out / "runs").mkdir(exist_ok=True)
    for run in runs:
        source, rows = store.folder / "runs" / f"{run.id}.h5", catalogue.blocks(run.id)
        if run.id in catalogue.runs_without_samples() or not source.exists():
            continue
        target = out / "runs" / source.name
        live = store.catalogue.run(run.id).state not in ENDED or run.state not in ENDED
        (_copy_live if live else _copy_whole)(source, target, rows)
        blocks, size = blocks + len(rows), size + target.stat().st_size
    return CopiedData(len(runs), blocks, size)


def _require_empty(out: Path) -> None:
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise StorageError("exists, and is not empty", where=str(out), remedy="name a new folder")


def _size_of_folder(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def _copy_tables(source: Connection, target: Connection, tables: Sequence[MetaData]) -> None:
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
    rows = source.execution_options(yield_per=_BATCH).execute(select(*columns)).mappings()
    for part in rows.partitions(_BATCH):
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


def _copy_whole(source: Path, target: Path, blocks: Sequence[BlockRecord]) -> None:
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


def _copy_live(source: Path, target: Path, blocks: Sequence[BlockRecord]) -> None:
    """Copy the committed blocks of a run that is being recorded into a closed file of the same layout.

    The bytes of a file that is written would be of different moments; its blocks are read as any reader does.

    Raises:
        StorageError: as for `_copy_whole`.
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
                    f"block {block.note.name} differs from the recording: CRC-32 {found:08x}, {block.crc32:08x} "
                    "expected",
                    where=str(target),
                    remedy="check the disk of the original; an older backup may still contain the block",
                )


def _flush_to_disk(target: Path) -> None:
    with target.open("rb+") as file:
        sync_file(file.fileno())
    sync_folder(target.parent)
