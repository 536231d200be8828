"""What runs inside a rig's process: the bench, its store, one run after the other."""

import os
import signal
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

from modallab.acquisition.link import Link
from modallab.acquisition.messages import Ended, Ready
from modallab.acquisition.run import Order, quieten, run_plan
from modallab.acquisition.supervisor import LifeLine
from modallab.backend.loader import open_bench
from modallab.backend.protocol import Bench
from modallab.errors import BenchError, ModallabError
from modallab.schema.plan import Plan
from modallab.schema.rig import Rig
from modallab.storage import Store

BROKEN_FILE_EXIT = 3


def serve(connection: Connection, url: str, rig: Rig, folder: Path, life_line: Connection | None = None) -> None:
    """Open the bench, bring its output to zero, and run plans until told to leave or until the owner is gone.

    Args:
        connection: to the owner.
        url: address of the bench.
        rig: what stands on it.
        folder: where the recordings go.
        life_line: to the supervisor, if there is one.
    """
    # Ctrl-C reaches every process of a terminal; the owner decides what it means, and stops the run in good order.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    link = Link(connection)
    try:
        _serve(link, url, rig, folder, LifeLine(life_line))
    except Exception as error:
        link.send(Ended(_expected(error)))
    link.flush()


def _serve(link: Link, url: str, rig: Rig, folder: Path, life: LifeLine) -> None:
    bench = open_bench(url, rig)
    try:
        bench.zero()
        with Store(folder) as store:
            store.recover()
            link.send(Ready(bench.info))
            while (command := link.next_plan()) is not None:
                _run(link, bench, rig, store, command.plan, life)
                life.idle()
    finally:
        quieten(bench)
        with suppress(BenchError):
            bench.close()


def _run(link: Link, bench: Bench, rig: Rig, store: Store, plan: Plan, life: LifeLine) -> None:
    error: ModallabError | None = None
    unusable = False

    def control() -> Order | None:
        life.working()
        return link.order()

    try:
        with store.begin(plan, rig, bench.info) as recorder:
            try:
                run_plan(bench, rig, plan, recorder, link.send, control)
            finally:
                unusable = recorder.unusable
    except Exception as raised:
        error = _expected(raised)
    link.send(Ended(error))
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
        remedy="report this with the log; the blocks before are kept",
    )
