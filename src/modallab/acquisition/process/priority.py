"""The loop that watches the limits goes before other programs where the system permits it."""

import os
import sys
from pathlib import Path

NICE = -15
"""So that a machine busy with ordinary programs still runs the loop within milliseconds of its samples. No real-time
class: a loop gone wrong must not keep the supervisor, or whoever would stop it, from the processor."""

HIGH_PRIORITY_CLASS = 0x80


def take_priority() -> str:
    """Raise all threads of this process; says in words what came of it, empty if all is well."""
    try:
        if sys.platform == "win32":
            _raise_priority_on_windows()
        else:
            _take_on_posix()
    except OSError as error:
        return (
            f"the watch on the limits runs at ordinary priority ({error.strerror or error}): on a busy machine a limit"
            " is acted on later; permit a negative nice value, or keep other programs off"
        )
    return ""


if sys.platform == "win32":

    def _raise_priority_on_windows() -> None:
        import ctypes

        kernel = ctypes.windll.kernel32
        if not kernel.SetPriorityClass(kernel.GetCurrentProcess(), HIGH_PRIORITY_CLASS):
            raise ctypes.WinError()

else:

    def _take_on_posix() -> None:
        tasks = Path("/proc/self/task")
        # A nice value is a thread's own on Linux; those that are started later inherit it.
        threads = [int(task.name) for task in tasks.iterdir()] if tasks.is_dir() else [0]
        for thread in threads:
            os.setpriority(os.PRIO_PROCESS, thread, NICE)
