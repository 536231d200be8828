"""The supervisor: opens the data folder, the rigs and the listeners, starts the processes, and watches over them."""

import logging
import os
import secrets
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Event as Flag
from threading import Thread
from typing import Self
from urllib.parse import urlsplit

from modallab.core.child_process import FileLock
from modallab.core.errors import ModallabError
from modallab.core.rig import Rig
from modallab.core.settings import Settings
from modallab.jobs import Jobs
from modallab.service.campaigns.purge import PurgeTimer
from modallab.service.errors import ServiceError
from modallab.service.jobs.background import IdentificationAfterRun, JobChangeLog
from modallab.service.process.child_processes import HeartbeatTimer, ProcessList, SupervisedProcess
from modallab.service.process.connections import bound_socket, port_taken_error, raise_connection_limit
from modallab.service.process.process_messages import CallServer
from modallab.service.process.stop_listener import StopListener
from modallab.service.process.tls import server_context
from modallab.service.process.workers import ComputingProcesses
from modallab.service.records.event_log import EventLog
from modallab.service.records.leases import RigLeases
from modallab.service.records.sessions import make_link
from modallab.service.rigs.controller import RigController, ServedRig
from modallab.service.rigs.controllers import RigControllers, rig_ids
from modallab.service.rigs.queue_runner import QueueRunner
from modallab.service.rigs.run_log import RunLog, RunRecovery
from modallab.storage import Store

LOG = logging.getLogger(__name__)
LOOK_S = 0.1
BEAT_LOOK_S = 0.05
LOCK = "service.lock"
API = "modallab.service.process.workers:run_api"
JOBS = "modallab.service.process.workers:run_jobs"
LEAVE_S = 5.0
"""For the jobs to be given back, when the supervisor has died."""


@dataclass(frozen=True, slots=True)
class ServiceAddress:
    """Where the service can be reached."""

    host: str
    port: int
    stop_port: int


class ServiceSupervisor:
    """The service. What moves is in processes of its own; here is only what must work when they do not."""

    def __init__(self, settings: Settings, rigs: Sequence[tuple[Rig, str]], token: str) -> None:
        """Open everything; `rigs` are (rig, address of its bench).

        Raises:
            ServiceError: another service uses the data folder, or a port is taken.
            StorageError: the data folder cannot be used.
        """
        # Inherited by every process that is started from here.
        raise_connection_limit()
        self._settings, self._token = settings, token
        self._closing = Flag()
        self._closed = Flag()
        self.store, self._lock = _locked_store(settings.data)
        self._orphans = ProcessList(settings.data)
        self._orphans.end_all()
        self._counter: CallServer | None = None
        boot = secrets.token_hex(8)
        log = EventLog(self.store.catalogue.engine, self._new_events)
        run_log = self._run_log = RunLog(self.store, log)
        jobs = self._queue = Jobs(self.store.catalogue.engine)
        self._watch = JobChangeLog(self.store.catalogue.engine, jobs, log)
        after = IdentificationAfterRun(self.store, jobs)
        self._recovery = RunRecovery(run_log, after)
        self._recovery.check_now()
        self._purge = PurgeTimer(self.store)
        listener = bound_socket(settings.host, settings.port)
        benches = _benches(rigs, run_log, settings.data)
        leases = RigLeases(self.store.catalogue.engine, boot)
        self.controllers = RigControllers([RigController(bench, run_log, after) for bench in benches], leases)
        self._stop = self._stop_listener()
        self.place = ServiceAddress(settings.host, listener.getsockname()[1], self._stop.port)
        settings = settings.model_copy(update={"stop_port": self._stop.port})
        self._api = SupervisedProcess("api", API, (settings, token, boot), self._api_started, handles=(listener,))
        self._jobs = SupervisedProcess("jobs", JOBS, (settings,), self._jobs_started, grace_s=LEAVE_S)
        self._computing: dict[str, int] = {}
        self._jobs_owner = ""
        self.controllers.others = self._processes
        self._queued_runs = QueueRunner(self.controllers, run_log, self._is_connected)
        self._look_after(self._api)
        for work in (self._keep, self._guard):
            Thread(target=work, name=work.__name__.strip("_"), daemon=True).start()

    def _stop_listener(self) -> StopListener:
        settings = self._settings
        pages = *settings.hosts, *(urlsplit(origin).hostname or "" for origin in settings.cors)
        try:
            return StopListener(
                settings.host, settings.stop_port, self.controllers.emergency_stop, pages, server_context(settings)
            )
        except OSError as error:
            self.controllers.close()
            raise port_taken_error(settings.stop_port, error) from error

    def wait(self) -> None:
        """Until `close` is called; in short waits, since on Windows Ctrl-C does not interrupt a long one."""
        while not self._closing.wait(0.2):
            pass

    def login_path(self) -> str:
        """A path of the REST service that logs a browser in, once, as whoever has the service's token.

        Raises:
            StorageError: it could not be kept.
        """
        return make_link(self.store.catalogue.engine, "", self._token)[0]

    def request_close(self) -> None:
        """Have `wait` return."""
        self._closing.set()

    def close(self) -> None:
        """Leave every rig at rest, and end the processes."""
        self._closing.set()
        self._queued_runs.request_close()
        # The outputs first; then nobody is waited for who was not asked to leave yet.
        self.controllers.request_close()
        for child in (self._api, self._jobs):
            child.request_exit()
        self.controllers.close()
        self._stop.close()
        for child in (self._api, self._jobs):
            child.close()
        if self._jobs_owner:
            self._free_jobs(self._jobs_owner)
        self._run_log.close()
        self._closed.set()
        self._orphans.close()
        self._lock.release()
        self.store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _api_started(self, connection: Connection) -> None:
        self._counter = CallServer(connection, self.controllers)

    def _jobs_started(self, connection: Connection) -> None:
        Thread(target=self._hear_jobs, args=(connection,), name="jobs", daemon=True).start()

    def _hear_jobs(self, connection: Connection) -> None:
        owner = ""
        with suppress(EOFError, OSError):
            while True:
                reported: ComputingProcesses = connection.recv()
                owner, self._computing = reported.owner, reported.processes
                self._jobs_owner = owner
        self._computing = {}
        if owner and not self._closing.is_set():
            self._free_jobs(owner)

    def _free_jobs(self, owner: str) -> None:
        try:
            self._queue.release(owner)
        except ModallabError as error:
            # Then its leases run out.
            LOG.warning("jobs of %s: %s", owner, error)

    def _processes(self) -> dict[str, int]:
        known = {"supervisor": os.getpid(), "api": self._api.pid, "jobs": self._jobs.pid}
        return {name: pid for name, pid in known.items() if pid is not None} | self._computing

    def _new_events(self) -> None:
        counter = self._counter
        if counter is not None:
            counter.new_events()

    def _keep(self) -> None:
        """Housekeeping, which may wait for a disk."""
        while not self._closing.wait(LOOK_S):
            try:
                self._look_after(self._api)
                if self._settings.jobs and self._counter is not None and self._counter.began:
                    # Its imports take seconds of processor time, and the REST service comes first.
                    self._look_after(self._jobs)
                for name, pid in self.controllers.rig_processes().items():
                    self._orphans.add(name, pid, leaves=True)
                self._run_log.log.flush()
                self._watch.check_now()
                self._recovery.check_now()
                self._purge.check_now()
            except Exception:
                LOG.exception("supervisor")
        # The system ends children with the thread that started them.
        self._closed.wait()

    def _look_after(self, child: SupervisedProcess) -> None:
        child.check_now()
        self._orphans.add(child.name, child.pid)

    def _guard(self) -> None:
        """The heartbeat, which waits for nothing."""
        tripped = False
        timer = HeartbeatTimer(self._settings.heartbeat_timeout_s, BEAT_LOOK_S)
        while not self._closing.wait(BEAT_LOOK_S):
            trouble = self._trouble(timer)
            if trouble and not tripped:
                self._trip(trouble)
            tripped = bool(trouble)

    def _trouble(self, timer: HeartbeatTimer) -> str:
        counter = self._counter
        if counter is None or not counter.began:
            return ""
        timed_out = timer.check_now(counter.received_s, self._api.used_s)
        # Started again it may be back within the second that it is given: its end alone is reason enough.
        return counter.end_message or (
            f"no heartbeat of the REST process for {counter.since_received_s:.1f} s" if timed_out else ""
        )

    def _is_connected(self) -> bool:
        """Whether somebody could see and command a run that begins now."""
        counter = self._counter
        if counter is None or not counter.began or counter.end_message:
            return False
        return counter.since_received_s <= self._settings.heartbeat_timeout_s

    def _trip(self, trouble: str) -> None:
        try:
            stopped = self.controllers.trip_driving(trouble)
        except ModallabError:
            LOG.exception("heartbeat: %s", trouble)
        else:
            LOG.warning("%s; stopped: %s", trouble, ", ".join(stopped) or "nothing was driven")


def _locked_store(folder: Path) -> tuple[Store, FileLock]:
    store, lock = Store(folder), FileLock(folder / LOCK)
    if not lock.acquire():
        store.close()
        raise ServiceError(
            "another service uses this data folder",
            where=str(folder),
            remedy="stop the other service, or name another folder",
        )
    return store, lock


def _benches(rigs: Sequence[tuple[Rig, str]], run_log: RunLog, folder: Path) -> list[ServedRig]:
    ids = rig_ids([rig.name for rig, _ in rigs])
    return [
        ServedRig(i, run_log.revisions.begin_with(i, rig), url, folder) for i, (rig, url) in zip(ids, rigs, strict=True)
    ]
