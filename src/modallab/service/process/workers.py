"""What runs in the processes that the supervisor starts: the REST service, and the computing of jobs."""

import gc
import json
import logging
import os
import signal
import sys
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from multiprocessing.connection import Connection
from socket import socket
from threading import Thread
from typing import TYPE_CHECKING, cast

from modallab.core.settings import Settings
from modallab.service.process.process_messages import RemoteControl

if TYPE_CHECKING:
    import uvicorn
    from fastapi import FastAPI

    from modallab.service.rigs.control import RigControl

LOOK_S = 0.2


class JsonLines(logging.Formatter):
    """A record as one line of JSON."""

    def format(self, record: logging.LogRecord) -> str:
        """The line."""
        said = {
            "utc": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname,
            "process": record.processName,
            "from": record.name,
            "what": record.getMessage(),
        }
        if record.exc_info:
            said["error"] = self.formatException(record.exc_info)
        return json.dumps(said)


def set_up(level: str) -> None:
    """Log to standard error."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines())
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
    for talker in ("distributed", "asyncio", "matplotlib"):
        logging.getLogger(talker).setLevel(logging.WARNING)
    # Whatever anyone sends, token or not, must not fill the disk with our log.
    logging.getLogger("uvicorn").setLevel(logging.ERROR)


def run_api(connection: Connection, listener: socket, settings: Settings, token: str, boot: str) -> None:
    """Serve on a socket that is bound already, until the supervisor is gone or says so."""
    # Ctrl-C reaches every process of a terminal; the supervisor decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    set_up(settings.log_level)
    # Imported here: the supervisor, which is the same program, needs none of it.
    import uvicorn

    from modallab.service.api.app import create_app
    from modallab.service.context import open_service

    server: uvicorn.Server | None = None

    def gone() -> None:
        # Connections that never end, such as those that follow events, must not keep it.
        # What it cuts is no error either.
        logging.getLogger("uvicorn").setLevel(logging.CRITICAL)
        if server is not None:
            server.should_exit = True
            server.force_exit = True

    control = RemoteControl(connection, gone)
    service = open_service(settings.data, cast("RigControl", control), boot)
    app = create_app(service, settings, token)
    control.on_events = app.state.feed.check_now
    server = uvicorn.Server(_configuration(app, settings))
    # What was imported stays for ever: whoever opens many connections at once must not have it looked through again.
    gc.collect()
    gc.freeze()
    try:
        # Not in the main thread, where it would take over Ctrl-C.
        serving = Thread(target=server.run, kwargs={"sockets": [listener]}, name="serve")
        serving.start()
        serving.join()
    finally:
        service.close()
    # A thread of a library that waits for a client would keep the process.
    os._exit(0)


def _configuration(app: "FastAPI", settings: Settings) -> "uvicorn.Config":
    import uvicorn

    from modallab.service.process.connections import guarded_protocol, raise_connection_limit

    return uvicorn.Config(
        app,
        log_config=None,
        access_log=False,
        server_header=False,
        http=guarded_protocol(raise_connection_limit()),
        ws="websockets-sansio",
        # Samples hardly shrink, and what shrinks them would keep everyone else waiting meanwhile.
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=1,
        ssl_certfile=settings.tls_cert,
        ssl_keyfile=settings.tls_key,
    )


@dataclass(frozen=True, slots=True)
class ComputingProcesses:
    """What the process reports: the name its jobs are held under, and the processes that it has started, by name."""

    owner: str
    processes: dict[str, int]


def run_jobs(connection: Connection, settings: Settings) -> None:
    """Compute jobs until the supervisor is gone or says so; it hears who holds them, and by which processes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    set_up(settings.log_level)
    # Imported here: the supervisor, which is the same program, needs none of it.
    from modallab.jobs import Jobs
    from modallab.jobs.runner import JobRunner
    from modallab.pipelines.job_kinds import campaigns_of, kinds
    from modallab.service.process.start_up import scheduler_certificates
    from modallab.storage import Store

    with Store(settings.data) as store:
        jobs = Jobs(store.catalogue.engine)
        known = kinds(campaigns_of(store), store.folder, store.revision, campaigns_of(store, ended=False))
        runner = JobRunner(
            jobs, known, settings.scheduler, tls=scheduler_certificates(settings), workers=settings.workers
        )
        # Before the first job is taken: whoever hears of this process' end knows then whose jobs are free.
        reported = ComputingProcesses(runner.owner, {})
        with suppress(EOFError, OSError):
            connection.send(reported)
            with runner:
                while not connection.poll(LOOK_S):
                    now = ComputingProcesses(runner.owner, runner.processes)
                    if reported != now:
                        reported = now
                        connection.send(reported)
