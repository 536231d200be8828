"""Which database a data folder keeps its catalogue in: its own file, or the server that it names."""

from pathlib import Path

from modallab.core.errors import FormatError, StorageError

DATABASE = "modallab.db"
ADDRESS = "database.url"
"""A text file with one line, the address of a PostgreSQL database: every program that opens the folder finds it."""


def database_of(folder: Path) -> str:
    """The SQLAlchemy URL of a data folder's catalogue.

    Raises:
        FormatError: the folder has a catalogue of its own and names a server too.
        StorageError: the address cannot be read.
    """
    own, address = folder / DATABASE, folder / ADDRESS
    if not address.exists():
        return f"sqlite:///{own.as_posix()}"
    if own.exists():
        raise FormatError(
            f"holds both {DATABASE} and {ADDRESS}",
            where=str(folder),
            remedy=f"move its runs to the server with modallab restore, or take {ADDRESS} away",
        )
    try:
        return address.read_text(encoding="utf-8").strip()
    except OSError as error:
        raise StorageError(
            f"cannot be read: {error.strerror}", where=str(address), remedy="check its rights"
        ) from error


def name_database(folder: Path, url: str) -> None:
    """Have a folder keep its catalogue on a server; the file may be read by its owner only.

    Raises:
        FormatError: the folder has a catalogue of its own.
    """
    folder.mkdir(parents=True, exist_ok=True)
    address = folder / ADDRESS
    address.touch(mode=0o600)
    address.write_text(url + "\n", encoding="utf-8")
    try:
        database_of(folder)
    except FormatError:
        address.unlink()
        raise
