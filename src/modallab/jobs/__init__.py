"""Durable jobs: a table that is the truth, and a runner that has them computed by Dask."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazy_getattr

if TYPE_CHECKING:
    from modallab.jobs.job import ComputationResult, Job, JobDefinition, JobPage, ProgressCallback
    from modallab.jobs.jobs import Jobs

__all__ = ["ComputationResult", "Job", "JobDefinition", "JobPage", "Jobs", "ProgressCallback"]

__getattr__ = lazy_getattr(
    __name__,
    {
        "job": ("ComputationResult", "Job", "JobPage", "JobDefinition", "ProgressCallback"),
        "jobs": ("Jobs",),
    },
)
