"""The connection to Dask: workers of this machine's own, or a scheduler elsewhere."""

import asyncio
import ipaddress
import logging
import os
import time
from collections.abc import Callable, Coroutine
from concurrent.futures import TimeoutError as NotYetError
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from urllib.parse import urlsplit

import psutil
from dask import config
from distributed import Client, Nanny, SpecCluster
from distributed.security import Security

from modallab.core.errors import JobError
from modallab.jobs.scheduler_process import HOST, SchedulerProcess


@dataclass(frozen=True, slots=True)
class TlsFiles:
    """Certificate files of one's own machines: each side shows its own and demands one by the same authority."""

    ca: Path
    cert: Path
    key: Path

    @classmethod
    def configured(cls) -> Self | None:
        """The files that Dask's own configuration or environment names for a client; None if it names none."""
        names = ("ca-file", "client.cert", "client.key")
        files = [config.get(f"distributed.comm.tls.{name}", None) for name in names]
        return cls(*(Path(file) for file in files)) if all(files) else None

    def security(self) -> Security:
        """As Dask wants it."""
        names = {"ca_file": self.ca, "client_cert": self.cert, "client_key": self.key}
        missing = [str(path) for path in names.values() if not path.is_file()]
        if missing:
            raise JobError(f"no such certificate file: {', '.join(missing)}", where="TLS", remedy="name existing files")
        files: dict[str, Any] = {f"tls_{name}": str(path) for name, path in names.items()}
        return Security(require_encryption=True, **files)


def check_address(scheduler: str, tls: TlsFiles | None) -> None:
    """Reject an address that would send recordings, and code, in the open.

    Raises:
        JobError: no `tcp://` or `tls://` address with a port; `tcp://` to another machine; `tls://` without files.
    """
    parts = urlsplit(scheduler)
    try:
        known = parts.scheme in ("tcp", "tls") and parts.hostname and parts.port
    except ValueError:
        known = False
    if not known:
        raise JobError(f"{scheduler!r} is no address of a scheduler", where="scheduler", remedy="as tls://machine:8786")
    if parts.scheme == "tcp" and not _is_loopback(parts.hostname or ""):
        raise JobError(
            f"{scheduler} is another machine, and tcp:// has neither encryption nor authentication",
            where="scheduler",
            remedy="start scheduler and workers with certificates, and use tls://",
        )
    if parts.scheme == "tls" and tls is None:
        raise JobError(
            f"{scheduler} needs certificates", where="scheduler", remedy="name authority, certificate and key"
        )


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


LOOK_S = 0.1
ASK_S = 60.0
"""A busy machine was never seen to need a third of it for an answer; a scheduler that is frozen needs for ever."""


class SchedulerLostError(ConnectionError):
    """The scheduler did not answer, and will not."""


def call_in_client_loop(
    client: Client, question: Coroutine[Any, Any, Any], alive: Callable[[], bool], patience_s: float = ASK_S
) -> Any:
    """The answer to `question`, which is asked by the client's own loop.

    Dask itself would go on knocking for ten seconds at the door of a scheduler whose process has ended.

    Raises:
        SchedulerLostError: `alive` says so meanwhile, or there was no answer for `patience_s`.
        OSError: the connection broke.
    """
    # Its types do not say which loop it runs on.
    loop: Any = client.loop
    asked = asyncio.run_coroutine_threadsafe(question, loop.asyncio_loop)
    end = time.monotonic() + patience_s
    try:
        while not asked.done():
            if not alive():
                raise SchedulerLostError("the scheduler ended during a request")
            if time.monotonic() > end:
                raise SchedulerLostError(f"the scheduler has not answered for {patience_s:g} s")
            try:
                return asked.result(LOOK_S)
            except NotYetError:
                continue
        return asked.result()
    finally:
        asked.cancel()


LOG = logging.getLogger(__name__)
CONNECT_S = 10.0
CLOSE_S = 10.0
MEND_S = 30.0
"""Longer than a busy machine needs to begin a process: a cluster that is only slow must not be started again."""
_CONFIG = {
    # Whole recordings go with the task: then it can run again when its worker is gone.
    "distributed.admin.large-graph-warning-threshold": "2 GiB",
    "distributed.comm.timeouts.connect": "5s",
    "distributed.comm.retry.count": 1,
    # A task whose worker died goes to another one, once; a second death is reported to the table, which counts.
    "distributed.scheduler.allowed-failures": 1,
    # What nobody looks at: a profile of 100 samples a second, and 50 looks a second whether an event loop is late.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}


class DaskCluster:
    """A client of a scheduler, and the scheduler and its workers too if they are this machine's own."""

    def __init__(self, client: Client, own: SpecCluster | None = None, requested: int = 0) -> None:
        self.client = client
        self._own = own
        self._requested = requested
        self._whole = time.monotonic()
        self.patience_s = ASK_S

    @classmethod
    def connect(cls, scheduler: str | None, tls: TlsFiles | None, workers: int) -> Self:
        """Connect, or start `workers` processes on the loopback if no scheduler is named.

        Raises:
            OSError: nobody answers there.
        """
        config.set(_CONFIG)
        if scheduler is not None:
            security = None if tls is None else tls.security()
            return cls(Client(scheduler, security=security, timeout=CONNECT_S, set_as_default=False))
        own = _local_cluster(workers)
        return cls(Client(own, timeout=CONNECT_S, set_as_default=False), own, workers)

    @property
    def is_alive(self) -> bool:
        """Whether the scheduler is there, as far as is known without asking it."""
        return self.client.status == "running" and (self._own is None or _process_of_cluster(self._own).pid is not None)

    @property
    def thread_count(self) -> int:
        """Computations that can go on at the same time; 0 while there is no worker.

        Raises:
            OSError: the scheduler is gone.
        """
        workers: dict[str, int] = self._ask("ncores")
        return sum(workers.values())

    @property
    def running_tasks(self) -> frozenset[str]:
        """Tasks of all runners that are at the workers.

        Raises:
            OSError: the scheduler is gone.
        """
        tasks: dict[str, tuple[str, ...]] = self._ask("processing")
        return frozenset(key for keys in tasks.values() for key in keys)

    @property
    def processes(self) -> dict[str, int]:
        """This machine's own scheduler and workers that live, by name, with the system's number of each."""
        if self._own is None:
            return {}
        workers = {f"worker {name}": nanny.pid for name, nanny in list(self._own.workers.items())}
        found = {"scheduler": _process_of_cluster(self._own).pid} | workers
        return {name: pid for name, pid in found.items() if pid is not None}

    def needs_restart(self, idle: bool) -> bool:
        """Whether workers of this machine's own died and did not come back, and nothing is lost by starting again.

        Dask replaces a worker that dies, but not one that dies the moment it has come up.
        """
        threads = self.thread_count
        if threads >= self._requested:
            self._whole = time.monotonic()
        return (idle or threads == 0) and time.monotonic() - self._whole > MEND_S

    def close(self) -> None:
        """Leave, and end what was started here."""
        if self._own is not None and _process_of_cluster(self._own).pid is None:
            # Nobody is there to be notified, and Dask would try until its patience is over.
            self._own.shutdown_scheduler = False
            # Nor do its workers have anything to bring any more; Dask would wait four seconds for what they compute.
            for name, pid in self.processes.items():
                with suppress(psutil.Error):
                    LOG.info("%s is ended with its scheduler", name)
                    psutil.Process(pid).kill()
        for part in (self.client, self._own):
            try:
                if part is not None:
                    part.close(timeout=CLOSE_S)
            except OSError:
                # The other side is gone already; its processes end by themselves.
                continue
        if self._own is not None:
            # One that is frozen has heard nothing of this.
            _process_of_cluster(self._own).end()

    def _ask(self, what: str) -> Any:
        scheduler: Any = self.client.scheduler
        try:
            if scheduler is None:
                raise SchedulerLostError("the scheduler ended")
            return call_in_client_loop(
                self.client, getattr(scheduler, what)(workers=None), lambda: self.is_alive, self.patience_s
            )
        except SchedulerLostError:
            if self._own is not None:
                # Frozen, it would keep whoever closes it waiting; it holds nothing that is not in the table.
                _process_of_cluster(self._own).kill()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _local_cluster(workers: int) -> SpecCluster:
    one_thread = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    options = {"host": HOST, "nthreads": 1, "dashboard": False, "silence_logs": logging.CRITICAL, "env": one_thread}
    # The level is what Dask wants here, whatever its types say.
    critical: Any = logging.CRITICAL
    return SpecCluster(
        scheduler={"cls": SchedulerProcess, "options": {"settings": _CONFIG}},
        workers={n: {"cls": Nanny, "options": options} for n in range(workers)},
        silence_logs=critical,
    )


def _process_of_cluster(cluster: SpecCluster) -> SchedulerProcess:
    scheduler: Any = cluster.scheduler
    return scheduler


def default_workers() -> int:
    """All processors but one, which the recording keeps."""
    return max(1, (os.cpu_count() or 2) - 1)
