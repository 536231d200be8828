"""What a test asks of the machine it runs on: to stay awake while it drives, and to look at the limits first.

Asleep, it neither feeds the output nor ends it.

Linux and macOS have a command that holds sleep off as long as another command runs; that one is `cat`, which ends with
the pipe from this process however this process ends. Windows is asked by the thread that runs the test.
"""

import os
import select
import shutil
import subprocess
import sys
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path

HELD = "this machine is kept awake"
NOT_HELD = "this machine could NOT be kept awake ({}): switch its sleep off before you drive"

ANSWER_S = 3.0
_WHILE_CAT = ("sh", "-c", "echo held; exec cat")
_LINUX = ("systemd-inhibit", "--who=modallab", "--why=a shaker is driven", "--mode=block")
_WAYS: dict[str, tuple[tuple[str, ...], ...]] = {
    # Some rights cover sleep and not the lid.
    "linux": ((*_LINUX, "--what=sleep:idle:handle-lid-switch"), (*_LINUX, "--what=sleep:idle")),
    "darwin": (("caffeinate", "-is"),),
}

_CONTINUOUS, _SYSTEM_REQUIRED = 0x80000000, 0x00000001
_NICE = -15
"""So that a machine busy with ordinary programs still runs the loop within milliseconds of its samples. No real-time
class: a loop gone wrong must not keep the supervisor, or whoever would stop it, from the processor."""

_HIGH_PRIORITY_CLASS = 0x80


@contextmanager
def keep_awake() -> Generator[str]:
    """While the context is open the machine does not fall asleep, where that can be had; yields what came of it.

    Enter and leave it in the same thread.
    """
    if sys.platform == "win32":
        with _thread_required() as said:
            yield said
    else:
        with _command_held(_WAYS.get(sys.platform, ())) as said:
            yield said


@contextmanager
def _thread_required() -> Generator[str]:
    import ctypes

    # Loaded by name, since only Windows' ctypes has it.
    kernel = getattr(ctypes, "windll").kernel32  # noqa: B009
    held = bool(kernel.SetThreadExecutionState(_CONTINUOUS | _SYSTEM_REQUIRED))
    try:
        yield HELD if held else NOT_HELD.format("Windows rejected it")
    finally:
        kernel.SetThreadExecutionState(_CONTINUOUS)


@contextmanager
def _command_held(ways: Sequence[tuple[str, ...]]) -> Generator[str]:
    why = "this system has no command to keep the machine awake"
    for way in ways:
        if shutil.which(way[0]) is None:
            why = f"there is no {way[0]}"
            continue
        # In a session of its own: no terminal to ask for a password on.
        holder = subprocess.Popen(
            (*way, *_WHILE_CAT),
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        try:
            if _lock_answers(holder):
                yield HELD
                return
            why = f"{way[0]} was rejected"
        finally:
            _let_go(holder)
    yield NOT_HELD.format(why)


def _lock_answers(holder: "subprocess.Popen[bytes]") -> bool:
    assert holder.stdout is not None
    ready, _, _ = select.select([holder.stdout], [], [], ANSWER_S)
    return bool(ready) and holder.stdout.readline() == b"held\n"


def _let_go(holder: "subprocess.Popen[bytes]") -> None:
    assert holder.stdin is not None
    assert holder.stdout is not None
    holder.stdin.close()
    try:
        holder.wait(ANSWER_S)
    except subprocess.TimeoutExpired:
        holder.kill()
        holder.wait()
    holder.stdout.close()


def raise_priority() -> str:
    """Raise all threads of this process; says in words what came of it, empty if all is well."""
    try:
        if sys.platform == "win32":
            _raise_priority_on_windows()
        else:
            _take_on_posix()
    except OSError as error:
        return (
            f"the check of the limits runs at ordinary priority ({error.strerror or error}): on a busy machine it "
            "reacts"
            " later; permit a negative nice value, or stop other programs"
        )
    return ""


if sys.platform == "win32":

    def _raise_priority_on_windows() -> None:
        import ctypes

        kernel = ctypes.windll.kernel32
        if not kernel.SetPriorityClass(kernel.GetCurrentProcess(), _HIGH_PRIORITY_CLASS):
            raise ctypes.WinError()

else:

    def _take_on_posix() -> None:
        tasks = Path("/proc/self/task")
        # A nice value is a thread's own on Linux; those that are started later inherit it.
        threads = [int(task.name) for task in tasks.iterdir()] if tasks.is_dir() else [0]
        for thread in threads:
            os.setpriority(os.PRIO_PROCESS, thread, _NICE)
