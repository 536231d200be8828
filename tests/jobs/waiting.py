"""Waiting for what must come about."""

import time
from collections.abc import Callable

from modallab.jobs import Job, Jobs

PATIENCE_S = 600.0
"""No limit of what is right, only of what is stuck: on a busy machine a process takes a minute to begin."""


def until(said: Callable[[], bool], patience_s: float = PATIENCE_S) -> None:
    """Wait until something holds."""
    deadline = time.monotonic() + patience_s
    while not said():
        assert time.monotonic() < deadline, "it did not come about"
        time.sleep(0.02)


def ended(jobs: Jobs, *listed: Job, patience_s: float = PATIENCE_S) -> list[Job]:
    """The jobs, once all have ended."""
    until(lambda: all(jobs.get(job.id).has_ended for job in listed), patience_s)
    return [jobs.get(job.id) for job in listed]
