"""A whole and consistent copy of a data folder, also while a run is being recorded, and the way back."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import MetaData

from modallab.core.errors import StorageError
from modallab.storage.address import database_of, name_database
from modallab.storage.catalogue import Catalogue
from modallab.storage.copies import copy_live, copy_tables, copy_whole
from modallab.storage.durable import require_space
from modallab.storage.records import ENDED
from modallab.storage.service_tables import METADATA
from modallab.storage.store import Store

RESULTS = "results"


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
    catalogue = Catalogue(database_of(out))
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


def _copy_catalogue(source: Catalogue, target: Catalogue, also: Sequence[MetaData]) -> None:
    tables = [METADATA, *also]
    moment = source.engine.connect().execution_options(reading=True)
    if moment.dialect.name == "postgresql":
        moment = moment.execution_options(isolation_level="REPEATABLE READ")
    with moment as reading, target.engine.begin() as writing:
        for metadata in tables:
            metadata.create_all(writing)
        writing.execute(METADATA.tables["store"].delete())
        copy_tables(reading, writing, tables)


def _copy_samples(store: Store, catalogue: Catalogue, out: Path) -> CopiedData:
    runs, blocks, size = catalogue.runs(), 0, 0
    (out / "runs").mkdir(exist_ok=True)
    for run in runs:
        source, rows = store.folder / "runs" / f"{run.id}.h5", catalogue.blocks(run.id)
        if run.id in catalogue.removed() or not source.exists():
            continue
        target = out / "runs" / source.name
        live = store.catalogue.run(run.id).state not in ENDED or run.state not in ENDED
        (copy_live if live else copy_whole)(source, target, rows)
        blocks, size = blocks + len(rows), size + target.stat().st_size
    return CopiedData(len(runs), blocks, size)


def _require_empty(out: Path) -> None:
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise StorageError("is there already, and not empty", where=str(out), remedy="name a new folder")


def _size_of_folder(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
