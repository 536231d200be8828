"""A lock that dies with its process, so that a run left behind by a crash is not taken for one that is going on."""

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Self

if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


class Lease:
    """An exclusive lock on a small file; the operating system lets go of it when the holder dies, however it dies."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._descriptor: int | None = None

    def acquire(self) -> bool:
        """Take the lease; False if another process, or another `Lease` of this one, holds it."""
        while True:
            descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                _lock(descriptor)
            except OSError:
                os.close(descriptor)
                return False
            if self._is_named(descriptor):
                self._descriptor = descriptor
                return True
            # Its holder removed the file just now: who comes next makes a new one, and would hold that.
            os.close(descriptor)

    def release(self) -> None:
        """Let go and remove the file; nothing to do if it is not held."""
        if self._descriptor is None:
            return
        if sys.platform != "win32":
            # While it is still held, or a file that another has taken since would be removed.
            self._path.unlink(missing_ok=True)
        os.close(self._descriptor)
        self._descriptor = None
        if sys.platform == "win32":
            # A file that is open cannot be removed there: nor can one that another holds.
            with suppress(OSError):
                self._path.unlink(missing_ok=True)

    def _is_named(self, descriptor: int) -> bool:
        try:
            return os.path.samestat(os.fstat(descriptor), self._path.stat())
        except FileNotFoundError:
            return False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()
