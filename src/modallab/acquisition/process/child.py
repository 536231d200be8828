"""What runs inside a rig's process: the bench, its store, one run after the other."""

import os
import select
import shutil
import signal
import subprocess
import sys
from collections.abc import Generator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path

from modallab.acquisition.monitor.live import IDLE, LiveRingBuffer, remove_stale_ring_buffers
from modallab.acquisition.monitor.run_states import ExcitationState
from modallab.acquisition.process.idle_view import IdleView, idle_ring_buffer_name
from modallab.acquisition.process.output_supervisor import HeartbeatPipe
from modallab.acquisition.process.owner_link import BenchOpened, OwnerLink, RunEnded, RunPlan
from modallab.acquisition.process.prepare_run import Order
from modallab.acquisition.process.run import run_plan, stop_output_and_bench
from modallab.acquisition.process.trip import TripLatch
from modallab.bench.loader import open_bench
from modallab.bench.protocol import Bench
from modallab.core.errors import BenchError, ModallabError
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.storage import Store
from modallab.storage.records import ENDED

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
def prevent_sleep() -> Generator[str]:
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


BROKEN_FILE_EXIT = 3
LOOK_S = 0.25
"""Between two looks whether somebody wants to see the channels while no run is on."""


def serve_rig(
    connection: Connection, life_line: Connection | None, url: str, rig: Rig, folder: Path, supervision: str
) -> None:
    """Open the bench, bring its output to zero, and run plans until asked to leave or until the owner is gone.

    Args:
        connection: to the owner.
        life_line: to the supervisor, if there is one.
        url: address of the bench.
        rig: what stands on it.
        folder: where the recordings go.
        supervision: what ends the output should this process die, in words; reported before anything is driven.
    """
    # Ctrl-C reaches every process of a terminal; the owner decides what it means, and stops the run in good order.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    link = OwnerLink(connection)
    try:
        _serve(link, url, rig, folder, OutputGuard(HeartbeatPipe(life_line), TripLatch(folder, url), supervision))
    except Exception as error:
        link.send(RunEnded(_expected(error)))
    link.flush()


@dataclass(frozen=True, slots=True)
class OutputGuard:
    """What answers for the output besides this process.

    Attributes:
        life: to the supervisor.
        latch: of the emergency stop.
        supervision: in words.
    """

    life: HeartbeatPipe
    latch: TripLatch
    supervision: str


def _serve(link: OwnerLink, url: str, rig: Rig, folder: Path, guard: OutputGuard) -> None:
    bench = open_bench(url, rig)
    try:
        bench.zero()
        if bench.info.real_time and (ordinary := raise_priority()):
            guard = replace(guard, supervision="; ".join(filter(None, (guard.supervision, ordinary))))
        with Store(folder) as store:
            store.recover()
            remove_stale_ring_buffers(folder, lambda name: _is_over(store, name, url))
            link.send(BenchOpened(bench.info))
            scope = IdleView(bench, rig, folder)
            while (command := _next_plan(link, scope)) is not None:
                _run(link, bench, rig, store, command, guard)
                guard.life.report_idle()
    finally:
        stop_output_and_bench(bench)
        with suppress(BenchError):
            bench.close()


def _is_over(store: Store, name: str, url: str) -> bool:
    if name.startswith(IDLE):
        return name == idle_ring_buffer_name(url)
    return store.catalogue.run(name).state in ENDED


def _next_plan(link: OwnerLink, scope: IdleView) -> RunPlan | None:
    while not link.has_plan(LOOK_S):
        if scope.is_wanted:
            scope.show(lambda: link.has_plan(0.0))
    return link.next_plan()


def _run(link: OwnerLink, bench: Bench, rig: Rig, store: Store, order: RunPlan, guard: OutputGuard) -> None:
    error: ModallabError | None = None
    unusable = False
    excitation = ExcitationState()
    sleep_lock = nullcontext("") if isinstance(order.plan, ImpactPlan) or not bench.info.real_time else prevent_sleep()

    def control() -> Order | None:
        guard.life.report_running(driving=excitation.on)
        return link.next_order()

    try:
        with (
            store.begin(order.plan, rig, bench.info) as recorder,
            LiveRingBuffer(store.folder) as live,
            sleep_lock as held,
        ):
            try:
                run_plan(
                    bench, rig, order.plan, recorder, link.send, control,
                    requests=link.requests, latch=guard.latch, excitation=excitation,
                    supervision="; ".join(filter(None, (guard.supervision, held))),
                    live=live, expected=order.expected,
                )  # fmt: skip
            finally:
                unusable = recorder.left_unusable_file
    except Exception as raised:
        error = _expected(raised)
    link.send(RunEnded(error))
    if unusable:
        # HDF5 brings the process down when it ends with a file it could not write; so it ends without HDF5.
        with suppress(BenchError):
            bench.close()
        link.flush()
        os._exit(BROKEN_FILE_EXIT)


def _expected(error: Exception) -> ModallabError:
    if isinstance(error, ModallabError):
        return error
    return BenchError(
        f"unexpected {type(error).__name__} in the acquisition process: {error}",
        remedy="report this with the log; earlier blocks are kept",
    )
