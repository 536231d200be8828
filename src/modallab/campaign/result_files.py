"""Files that jobs leave: reports, as pages."""

from modallab.campaign.errors import NotFoundError
from modallab.campaign.orders import campaign_jobs
from modallab.campaign.service import Service
from modallab.errors import StorageError
from modallab.jobs import Job


def newest_file(service: Service, campaign: str, kind: str, name: str) -> bytes:
    """The file of the newest job of a kind that is done.

    Raises:
        NotFoundError: no such campaign, or no such job is done.
        StorageError: the file cannot be read.
    """
    for job in campaign_jobs(service, campaign, kind):
        if job.state == "done":
            return job_file(service, job, name)
    raise NotFoundError(f"campaign {campaign} has no {kind} that is done", where=campaign, remedy="order one, and wait")


def job_file(service: Service, job: Job, name: str) -> bytes:
    """A file that a job left.

    Raises:
        NotFoundError: it left none of this name.
        StorageError: the file cannot be read.
    """
    result = job.result if isinstance(job.result, dict) else {}
    files = result.get("files")
    place = files.get(name) if isinstance(files, dict) else None
    if not isinstance(place, str):
        raise NotFoundError(f"job {job.id} left no file {name!r}", where=job.id, remedy="look at its result")
    try:
        return (service.folder / place).read_bytes()
    except OSError as error:
        raise StorageError(f"cannot be read: {error.strerror}", where=place, remedy="order it again") from error
