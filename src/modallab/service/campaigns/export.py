"""A campaign's runs as a file of a format that others read."""

import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from modallab.core.errors import StorageError
from modallab.formats.format import find_writer
from modallab.service.context import Service
from modallab.service.errors import ConflictError
from modallab.storage.records import ENDED


@dataclass(frozen=True, slots=True)
class ExportedFile:
    """A file in a folder of its own, which whoever sends it removes.

    Attributes:
        path: of the file.
        notes: what had no place in the format, in plain sentences.
    """

    path: Path
    notes: tuple[str, ...]

    def remove(self) -> None:
        """Remove the file with its folder."""
        shutil.rmtree(self.path.parent, ignore_errors=True)


def export_campaign(service: Service, campaign: str, format_: str) -> ExportedFile:
    """Write the valid runs of a campaign, with the blocks that count, as one file; a format that is a folder as a zip.

    Raises:
        NotFoundError: there is no such campaign.
        ConflictError: it has no valid run with good blocks that has ended.
        DataError: no such format, or one that holds nothing of it.
        StorageError, DiskFullError: it cannot be read or written.
    """
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.formats.exporter import write_export
    from modallab.storage.campaigns import campaign_of

    used = find_writer(format_)
    runs = tuple(run for run in service.repository.campaign(campaign).runs if _counts(service, run))
    if not runs:
        raise ConflictError("there is no ended, valid run with good blocks", where=campaign, remedy="record one first")
    whole, name = campaign_of(service.store, runs), f"{campaign}{used.endings[0]}"
    return export_to_own_folder(service, name, lambda path: write_export(whole, path, format_))


def export_to_own_folder(service: Service, name: str, write: Callable[[Path], Sequence[str] | None]) -> ExportedFile:
    """A file in a folder of its own; a folder as a zip.

    Args:
        service: whose disk it is on.
        name: of the file.
        write: it, and says what had no place in it.

    Raises:
        StorageError, DiskFullError: it cannot be written.
    """
    folder = Path(tempfile.mkdtemp(prefix="modallab-export-", dir=service.folder))
    try:
        notes = write(folder / name)
        return ExportedFile(_one_file(folder / name), tuple(notes or ()))
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _one_file(written: Path) -> Path:
    """What was written, a folder as a zip beside it.

    Raises:
        StorageError: it cannot be written.
    """
    if not written.is_dir():
        return written
    try:
        packed = Path(shutil.make_archive(str(written), "zip", written))
        shutil.rmtree(written)
        return packed
    except OSError as error:
        raise StorageError(f"cannot be written: {error.strerror}", where=written.name, remedy="make room") from error


def _counts(service: Service, run: str) -> bool:
    record = service.store.catalogue.run(run)
    return record.state in ENDED and record.valid and any(b.note.accepted for b in service.store.catalogue.blocks(run))
