"""What runs in the process that has jobs computed."""

import signal
from contextlib import suppress
from multiprocessing.connection import Connection

from modallab.serve.log import set_up
from modallab.settings import Settings

LOOK_S = 0.2


def run_jobs(connection: Connection, settings: Settings) -> None:
    """Compute jobs until the supervisor is gone or says so; it is told which processes were started for that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    set_up(settings.log_level)
    # Imported here: the supervisor, which is the same program, needs none of it.
    from modallab.jobs import Jobs
    from modallab.jobs.runner import Runner
    from modallab.serve.remote import tls_of
    from modallab.storage import Store
    from modallab.tasks.kinds import campaigns_of, kinds

    with Store(settings.data) as store:
        jobs = Jobs(store.catalogue.engine)
        known = kinds(campaigns_of(store), store.folder)
        runner = Runner(jobs, known, settings.scheduler, tls=tls_of(settings), workers=settings.workers)
        with runner, suppress(EOFError, OSError):
            told: dict[str, int] | None = None
            while not connection.poll(LOOK_S):
                if told != runner.processes:
                    told = runner.processes
                    connection.send(told)
