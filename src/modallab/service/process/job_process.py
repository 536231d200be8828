"""What runs in the process that has jobs computed."""

import signal
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection

from modallab.core.settings import Settings
from modallab.service.process.log import set_up

LOOK_S = 0.2


@dataclass(frozen=True, slots=True)
class Computing:
    """What the process reports: the name its jobs are held under, and the processes that it has started, by name."""

    owner: str
    processes: dict[str, int]


def run_jobs(connection: Connection, settings: Settings) -> None:
    """Compute jobs until the supervisor is gone or says so; it is informed who holds them, by which processes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    set_up(settings.log_level)
    # Imported here: the supervisor, which is the same program, needs none of it.
    from modallab.jobs import Jobs
    from modallab.jobs.runner import Runner
    from modallab.pipelines.job_kinds import campaigns_of, kinds
    from modallab.service.process.remote import tls_of
    from modallab.storage import Store

    with Store(settings.data) as store:
        jobs = Jobs(store.catalogue.engine)
        known = kinds(campaigns_of(store), store.folder)
        runner = Runner(jobs, known, settings.scheduler, tls=tls_of(settings), workers=settings.workers)
        # Before the first job is taken: whoever hears of this process' end knows then whose jobs are free.
        reported = Computing(runner.owner, {})
        with suppress(EOFError, OSError):
            connection.send(reported)
            with runner:
                while not connection.poll(LOOK_S):
                    now = Computing(runner.owner, runner.processes)
                    if reported != now:
                        reported = now
                        connection.send(reported)
