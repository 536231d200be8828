"""A Dask scheduler in a process of its own, beside the one that orders its work: neither takes the other along."""

import asyncio
import logging
import multiprocessing
import os
import signal
from collections.abc import Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from dask import config
from distributed import Scheduler
from distributed.core import Status
from distributed.deploy.spec import ProcessInterface

HOST = "127.0.0.1"
START_S = 120.0
LEAVE_S = 5.0


class SchedulerProcess(ProcessInterface):
    """What a `SpecCluster` starts as its scheduler."""

    def __init__(self, settings: Mapping[str, Any]) -> None:
        """`settings` are Dask's, as they are to hold in the scheduler."""
        self._settings = dict(settings)
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None
        super().__init__()

    @property
    def pid(self) -> int | None:
        """The system's number of it; None while it is not there."""
        process = self._process
        return process.pid if process is not None and process.is_alive() else None

    @property
    def status(self) -> Status:
        """Running only as long as the process is: whoever asks a dead one to do something would wait in vain."""
        gone = self._status == Status.running and self.pid is None
        return Status.failed if gone else self._status

    @status.setter
    def status(self, new_status: Status) -> None:
        self._status = new_status

    async def start(self) -> None:
        """Start it and wait for its address.

        Raises:
            OSError: it did not come up.
        """
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        self._connection = ours
        self._process = context.Process(
            target=run_scheduler, args=(theirs, self._settings), name="scheduler", daemon=True
        )
        self._process.start()
        theirs.close()
        self.address = await asyncio.to_thread(self._received_address)
        await super().start()

    async def close(self) -> None:
        """Ask it to leave, and see that it does."""
        if self._connection is not None:
            with suppress(OSError):
                self._connection.send(None)
        await asyncio.to_thread(self.end)
        await super().close()

    def end(self) -> None:
        """Wait until the process has left, and end it if it does not."""
        if self._process is not None:
            self._process.join(LEAVE_S)
            self.kill()

    def kill(self) -> None:
        """End the process, whatever it does."""
        if self._process is not None:
            self._process.kill()
            self._process.join()

    def _received_address(self) -> str:
        assert self._connection is not None
        try:
            if not self._connection.poll(START_S):
                raise TimeoutError(f"the scheduler gave no address within {START_S:g} s")
            return self._connection.recv()
        except EOFError as error:
            raise OSError("the scheduler ended before it reported its address") from error


def run_scheduler(connection: Connection, settings: Mapping[str, Any]) -> None:
    """In the process: schedule until asked to leave, or until whoever would say so is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    config.set(settings)
    asyncio.run(_schedule(connection))


async def _schedule(connection: Connection) -> None:
    # Whoever asks for port 0 never fights with another service for one, nor for one of the dashboard.
    async with Scheduler(host=HOST, port=0, dashboard=False, dashboard_address=f"{HOST}:0") as scheduler:
        connection.send(scheduler.address)
        await asyncio.to_thread(_leave_when_asked, connection)


def _leave_when_asked(connection: Connection) -> None:
    with suppress(EOFError, OSError):
        connection.recv()
    # It keeps nothing: the table of jobs does. Whoever is connected hears at once that it is gone.
    os._exit(0)
