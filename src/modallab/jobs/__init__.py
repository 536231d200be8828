"""Durable jobs: a table that is the truth, and a runner that has them computed by Dask."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazy_getattr

if TYPE_CHECKING:
    from modallab.jobs.job import Job, JobPage, JobState
    from modallab.jobs.jobs import Jobs
    from modallab.jobs.kind import ComputationResult, Kind, Notify

__all__ = ["ComputationResult", "Job", "JobPage", "JobState", "Jobs", "Kind", "Notify"]

__getattr__ = lazy_getattr(
    __name__,
    {
        "job": ("Job", "JobPage", "JobState"),
        "jobs": ("Jobs",),
        "kind": ("ComputationResult", "Kind", "Notify"),
    },
)
