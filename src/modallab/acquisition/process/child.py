"""What runs inside a rig's process: the bench, its store, one run after the other."""

import os
import signal
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path

from modallab.acquisition.monitor.live import IDLE, LiveRingBuffer, remove_stale_ring_buffers
from modallab.acquisition.monitor.run_states import Excitation
from modallab.acquisition.process.idle_view import IdleView, idle_ring_buffer_name
from modallab.acquisition.process.machine_settings import keep_awake, raise_priority
from modallab.acquisition.process.output_supervisor import HeartbeatPipe
from modallab.acquisition.process.owner_link import BenchOpened, OwnerLink, RunEnded, RunPlan
from modallab.acquisition.process.prepare_run import Order
from modallab.acquisition.process.run import make_safe, run_plan
from modallab.acquisition.process.trip import TripLatch
from modallab.bench.loader import open_bench
from modallab.bench.protocol import Bench
from modallab.core.errors import BenchError, ModallabError
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.storage import Store
from modallab.storage.records import ENDED

BROKEN_FILE_EXIT = 3
LOOK_S = 0.25
"""Between two looks whether somebody wants to see the channels while no run is on."""


def serve(
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
                guard.life.idle()
    finally:
        make_safe(bench)
        with suppress(BenchError):
            bench.close()


def _is_over(store: Store, name: str, url: str) -> bool:
    if name.startswith(IDLE):
        return name == idle_ring_buffer_name(url)
    return store.catalogue.run(name).state in ENDED


def _next_plan(link: OwnerLink, scope: IdleView) -> RunPlan | None:
    while not link.has_plan(LOOK_S):
        if scope.wanted:
            scope.show(lambda: link.has_plan(0.0))
    return link.next_plan()


def _run(link: OwnerLink, bench: Bench, rig: Rig, store: Store, order: RunPlan, guard: OutputGuard) -> None:
    error: ModallabError | None = None
    unusable = False
    excitation = Excitation()
    sleep_lock = nullcontext("") if isinstance(order.plan, ImpactPlan) or not bench.info.real_time else keep_awake()

    def control() -> Order | None:
        guard.life.working(driving=excitation.on)
        return link.order()

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
                unusable = recorder.unusable
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
