"""Takes jobs from the table, has them computed by Dask, and commits what comes back."""

import logging
import os
import secrets
import socket
import threading
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Literal, Self

from modallab.core.errors import StorageError
from modallab.jobs.attempt import TOPIC, JobAttempt
from modallab.jobs.cluster import DaskCluster, TlsFiles, check_address, default_workers
from modallab.jobs.job import JobDefinition
from modallab.jobs.jobs import Jobs
from modallab.jobs.leases import LEASE_S, JobLeases, LeasedJob

Status = Literal["stopped", "connecting", "running"]

POLL_S = 0.2
CLUSTER_S = 1.0
"""Between two looks whether the workers are all there, while no job waits: each is a question to the scheduler."""
_LOG = logging.getLogger(__name__)


class JobRunner:
    """Computes jobs until it is stopped. Any number of runners share one table, each by a name of its own: `owner`."""

    def __init__(
        self,
        jobs: Jobs,
        kinds: Iterable[JobDefinition],
        scheduler: str | None = None,
        *,
        tls: TlsFiles | None = None,
        workers: int | None = None,
        lease_s: float = LEASE_S,
    ) -> None:
        """Prepare; nothing is started yet.

        Args:
            jobs: the table.
            kinds: what can be computed.
            scheduler: address of a Dask scheduler, `tcp://` on the loopback or `tls://` anywhere; None for workers of
                this machine's own.
            tls: certificates for `tls://`; those of Dask's configuration (`distributed.comm.tls`) if None.
            workers: processes of this machine's own; one less than there are processors if None.
            lease_s: after so long without a sign of this runner, others take its jobs.

        Raises:
            JobError: an address that would not be safe.
        """
        if scheduler is not None:
            tls = tls or TlsFiles.configured()
            check_address(scheduler, tls)
        self._kinds = {kind.name: kind for kind in kinds}
        self._address = (scheduler, tls, workers or default_workers())
        self.owner = f"{socket.gethostname()[:32]}-{os.getpid()}-{secrets.token_hex(4)}"
        self._leases = JobLeases(jobs.engine, self.owner, lease_s)
        self._attempts: dict[str, JobAttempt] = {}
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []
        self._cluster: DaskCluster | None = None
        self._ask_next_s = 0.0
        self.status: Status = "stopped"
        self.trouble = ""

    @property
    def processes(self) -> dict[str, int]:
        """The scheduler and the workers that were started here and live, by name, with the system's number of each."""
        cluster = self._cluster
        return {} if cluster is None else cluster.processes

    def start(self) -> None:
        """Begin; returns at once. While no scheduler answers, `status` is "connecting" and `trouble` says why."""
        self._stop.clear()
        self.status = "connecting"
        self._threads = [
            threading.Thread(target=target, name=f"jobs-{target.__name__.strip('_')}", daemon=True)
            for target in (self._serve, self._hold)
        ]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Give what is being computed back to the table, for others or for later, and end the workers started here."""
        self._stop.set()
        for thread in self._threads:
            thread.join()
        self._threads = []
        self.status = "stopped"

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _serve(self) -> None:
        while not self._stop.is_set():
            try:
                with DaskCluster.connect(*self._address) as cluster:
                    self._compute_on(cluster)
            except Exception as error:
                # Whatever Dask met, jobs must go on once it is corrected.
                self.trouble = f"{type(error).__name__}: {error}"
                _LOG.warning("no scheduler: %s", self.trouble)
                self._stop.wait(1.0)
            self.status, self._cluster = "connecting", None

    def _compute_on(self, cluster: DaskCluster) -> None:
        self.status, self.trouble, self._cluster = "running", "", cluster
        cluster.client.subscribe_topic(TOPIC, self._note)
        with ThreadPoolExecutor(thread_name_prefix="job") as pool:
            try:
                while cluster.is_alive and not self._stop.wait(POLL_S) and not self._is_worn(cluster):
                    for taken in self._take(cluster):
                        pool.submit(self._run, taken, cluster)
            finally:
                for attempt in self._going_on():
                    attempt.give_back()

    def _is_worn(self, cluster: DaskCluster) -> bool:
        if time.monotonic() < self._ask_next_s:
            return False
        self._ask_next_s = time.monotonic() + CLUSTER_S
        return cluster.needs_restart(not self._attempts)

    def _take(self, cluster: DaskCluster) -> list[LeasedJob]:
        try:
            if not self._leases.has_open_job():
                return []
            # Never more than can go on at once: a task that waits at a worker shares the blame when it dies.
            room = cluster.thread_count - len(cluster.running_tasks | self._attempts.keys())
            return self._leases.lease_jobs(self._kinds, room)
        except StorageError as error:
            self.trouble = str(error)
            _LOG.warning("the table of jobs: %s", error)
            return []

    def _run(self, taken: LeasedJob, cluster: DaskCluster) -> None:
        attempt = JobAttempt(taken, self._kinds[taken.job.kind], self._leases, cluster.client)
        with self._lock:
            self._attempts[taken.attempt_name] = attempt
        try:
            attempt.run()
        except StorageError as error:
            # Not committed: the lease runs out, and the job is taken again.
            _LOG.warning("job %s: %s", taken.job.id, error)
        finally:
            with self._lock:
                del self._attempts[taken.attempt_name]

    def _hold(self) -> None:
        while not self._stop.wait(min(self._leases.lease_s / 5, 1.0)):
            going_on = self._going_on()
            try:
                lost = self._leases.renew({a.taken.job.id: (a.taken.fence, a.progress, a.stage) for a in going_on})
                for attempt in going_on:
                    if attempt.taken.job.id in lost or attempt.is_overdue:
                        attempt.interrupt()
            except Exception as error:
                # This thread must outlive whatever database or scheduler do: without it every lease runs out.
                _LOG.warning("leases were not renewed: %s", error)

    def _going_on(self) -> list[JobAttempt]:
        with self._lock:
            return list(self._attempts.values())

    def _note(self, event: tuple[float, dict[str, object]]) -> None:
        reported = event[1]
        attempt = self._attempts.get(str(reported["attempt"]))
        if attempt is not None:
            attempt.progress, attempt.stage = float(str(reported["progress"])), str(reported.get("stage", ""))
