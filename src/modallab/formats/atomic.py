"""Files that appear whole or not at all."""

import errno
import os
import secrets
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

from modallab.core.errors import DiskFullError, StorageError


@contextmanager
def replacing(path: Path) -> Generator[Path]:
    """A temporary file in the folder of `path`, which takes its place once everything is written and on the disk.

    Raises:
        StorageError: the folder is missing or cannot be written, or `path` is a folder itself.
        DiskFullError: the disk is full.
    """
    if path.is_dir():
        raise StorageError("is a folder", where=str(path), remedy="name a file in it")
    with _disk_errors(path):
        temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}.part")
        temporary.touch(exist_ok=False)
        try:
            yield temporary
            _flush(temporary)
            os.replace(temporary, path)
        except BaseException:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
            raise


def write_text(path: Path, text: str) -> None:
    """A text as a file: UTF-8, ends of line as they are; whole, or after an error as it was before.

    Raises:
        StorageError, DiskFullError: as `replacing`.
    """
    with replacing(path) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")


def make_folder(path: Path) -> None:
    """A folder for results, and those above it; git takes no notice of one that is made here.

    Raises:
        StorageError: it is a file, or cannot be made.
    """
    if path.is_dir():
        return
    with _disk_errors(path):
        if path.exists():
            raise StorageError("is a file", where=str(path), remedy="name a folder for the results")
        path.mkdir(parents=True)
        (path / ".gitignore").write_text("*\n", encoding="utf-8")


def _flush(path: Path) -> None:
    with path.open("rb+") as written:
        os.fsync(written.fileno())


@contextmanager
def _disk_errors(path: Path) -> Generator[None]:
    try:
        yield
    except OSError as error:
        if error.errno == errno.ENOSPC:
            raise DiskFullError(
                "the disk is full; nothing was written", where=str(path), remedy="free some space, or write elsewhere"
            ) from error
        raise StorageError(
            f"cannot be written: {error.strerror or error}",
            where=str(path),
            remedy="check that the folder exists, is not a file of the same name, and may be written to",
        ) from error
