"""The connection to Dask: workers of this machine's own, or a scheduler elsewhere."""

import ipaddress
import logging
import os
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self, cast
from urllib.parse import urlsplit

from dask import config
from distributed import Client, Nanny, SpecCluster
from distributed.security import Security

from modallab.errors import JobError
from modallab.jobs.scheduler_process import HOST, SchedulerProcess

CONNECT_S = 10.0
CLOSE_S = 10.0
MEND_S = 30.0
"""Longer than a busy machine needs to begin a process: a cluster that is only slow must not be started anew."""
_CONFIG = {
    # Whole recordings go with the task: then it can run again when its worker is gone.
    "distributed.admin.large-graph-warning-threshold": "2 GiB",
    "distributed.comm.timeouts.connect": "5s",
    "distributed.comm.retry.count": 1,
    # A task whose worker died goes to another one, once; a second death is told to the table, which counts.
    "distributed.scheduler.allowed-failures": 1,
}


@dataclass(frozen=True, slots=True)
class Tls:
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
            raise JobError(
                f"no such certificate file: {', '.join(missing)}", where="TLS", remedy="name the files you made"
            )
        files: dict[str, Any] = {f"tls_{name}": str(path) for name, path in names.items()}
        return Security(require_encryption=True, **files)


def check_address(scheduler: str, tls: Tls | None) -> None:
    """Refuse an address that would send recordings, and code, in the open.

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
            f"{scheduler} is another machine, and tcp:// is neither encrypted nor asks who is there",
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


class Cluster:
    """A client of a scheduler, and the scheduler and its workers too if they are this machine's own."""

    def __init__(self, client: Client, own: SpecCluster | None = None, wanted: int = 0) -> None:
        self.client = client
        self._own = own
        self._wanted = wanted
        self._whole = time.monotonic()

    @classmethod
    def connect(cls, scheduler: str | None, tls: Tls | None, workers: int) -> Self:
        """Connect, or start `workers` processes on the loopback if no scheduler is named.

        Raises:
            OSError: nobody answers there.
        """
        config.set(_CONFIG)
        if scheduler is not None:
            security = None if tls is None else tls.security()
            return cls(Client(scheduler, security=security, timeout=CONNECT_S, set_as_default=False))
        own = _local(workers)
        return cls(Client(own, timeout=CONNECT_S, set_as_default=False), own, workers)

    @property
    def alive(self) -> bool:
        """Whether the scheduler answers."""
        return self.client.status == "running"

    @property
    def threads(self) -> int:
        """Computations that can go on at the same time; 0 while there is no worker."""
        workers = cast("dict[str, int]", self.client.nthreads())
        return sum(workers.values())

    @property
    def busy(self) -> frozenset[str]:
        """Tasks of all runners that are at the workers."""
        tasks = cast("dict[str, tuple[str, ...]]", self.client.processing())
        return frozenset(key for keys in tasks.values() for key in keys)

    @property
    def processes(self) -> dict[str, int]:
        """This machine's own scheduler and workers that live, by name, with the system's number of each."""
        if self._own is None:
            return {}
        workers = {f"worker {name}": nanny.pid for name, nanny in list(self._own.workers.items())}
        found = {"scheduler": _pid(self._own)} | workers
        return {name: pid for name, pid in found.items() if pid is not None}

    def worn(self, idle: bool) -> bool:
        """Whether workers of this machine's own died and did not come back, and nothing is lost by starting anew.

        Dask replaces a worker that dies, but not one that dies the moment it has come up.
        """
        threads = self.threads
        if threads >= self._wanted:
            self._whole = time.monotonic()
        return (idle or threads == 0) and time.monotonic() - self._whole > MEND_S

    def close(self) -> None:
        """Leave, and end what was started here."""
        if self._own is not None and _pid(self._own) is None:
            # Nobody is there to be told, and Dask would try until its patience is over.
            self._own.shutdown_scheduler = False
        for part in (self.client, self._own):
            try:
                if part is not None:
                    part.close(timeout=CLOSE_S)
            except (OSError, TimeoutError):
                # The other side is gone already; its processes end by themselves.
                continue

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _local(workers: int) -> SpecCluster:
    one_thread = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    options = {"host": HOST, "nthreads": 1, "dashboard": False, "silence_logs": logging.CRITICAL, "env": one_thread}
    # The level is what Dask wants here, whatever its types say.
    quiet: Any = logging.CRITICAL
    return SpecCluster(
        scheduler={"cls": SchedulerProcess, "options": {"settings": _CONFIG}},
        workers={n: {"cls": Nanny, "options": options} for n in range(workers)},
        silence_logs=quiet,
    )


def _pid(cluster: SpecCluster) -> int | None:
    scheduler: object = cluster.scheduler
    return scheduler.pid if isinstance(scheduler, SchedulerProcess) else None


def default_workers() -> int:
    """All processors but one, which the recording keeps."""
    return max(1, (os.cpu_count() or 2) - 1)
