"""Processes that a service of this data folder left behind: noted when they are started, ended by the next one."""

import json
import logging
from contextlib import suppress
from pathlib import Path

import psutil

LOG = logging.getLogger(__name__)
NAME = "service.processes"
END_S = 5.0
CLOCK_S = 2.0
"""The moment a process began is known to so much."""
Known = tuple[int, float, bool]
"""The system's number of a process, when it began, and whether it leaves by itself once its owner is dead."""


class ProcessList:
    """The list of one data folder. Only who holds the folder's lock may use it."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / NAME
        self._known: dict[str, Known] = {}

    def end_all(self) -> tuple[int, ...]:
        """End those that still live: their service is dead, or the lock would be held. Returns their numbers.

        A rig's process brings its output to 0 V, commits and leaves; it is ended if it is frozen or does not leave.
        """
        living = [(process, leaves) for pid, began_s, leaves in self._read() if (process := _is_living(pid, began_s))]
        at_work = [process for process, leaves in living if leaves and not _is_frozen(process)]
        _, stuck = psutil.wait_procs(at_work, timeout=END_S)
        left = [process for process, _ in living if process not in at_work or process in stuck]
        for process in left:
            LOG.warning("process %d is left of an earlier service of this folder, and is ended", process.pid)
            with suppress(psutil.NoSuchProcess):
                process.kill()
        psutil.wait_procs(left, timeout=END_S)
        self._path.unlink(missing_ok=True)
        return tuple(process.pid for process in left)

    def note(self, name: str, pid: int | None, *, leaves: bool = False) -> None:
        """A process was started; `leaves` if it leaves by itself, in good order, once its owner is dead."""
        if pid is None or self._known.get(name, (0,))[0] == pid:
            return
        try:
            self._known[name] = (pid, psutil.Process(pid).create_time(), leaves)
            self._path.write_text(json.dumps(list(self._known.values())), encoding="ascii")
        except (psutil.Error, OSError) as error:
            # It ends by itself with its owner; this list is for whatever keeps it from doing so.
            LOG.warning("process %d was not noted: %s", pid, error)

    def close(self) -> None:
        """None is left."""
        self._path.unlink(missing_ok=True)

    def _read(self) -> list[Known]:
        try:
            rows = json.loads(self._path.read_text(encoding="ascii"))
            return [(int(pid), float(began_s), leaves == [True]) for pid, began_s, *leaves in rows]
        except (OSError, ValueError, TypeError):
            return []


def _is_frozen(process: psutil.Process) -> bool:
    try:
        return process.status() == psutil.STATUS_STOPPED
    except psutil.Error:
        return False


def _is_living(pid: int, began_s: float) -> psutil.Process | None:
    try:
        process = psutil.Process(pid)
        # A number that is used again is another process.
        return process if abs(process.create_time() - began_s) < CLOCK_S else None
    except psutil.Error:
        return None
