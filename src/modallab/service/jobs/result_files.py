"""Files that jobs leave: reports, as pages."""

from modallab.core.errors import StorageError
from modallab.jobs import Job
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.jobs.orders import campaign_jobs

_NOUN = {"diagnose": "diagnosis", "identify": "model"}


def newest_file(service: Service, campaign: str, kind: str, name: str) -> bytes:
    """The file of the newest job of a kind that is done.

    Raises:
        NotFoundError: no such campaign, or no such job is done.
        StorageError: the file cannot be read.
    """
    jobs = campaign_jobs(service, campaign, kind)
    for job in jobs:
        if job.state == "done":
            return job_file(service, job, name)
    raise _none_yet(campaign, _NOUN.get(kind, kind), next(iter(jobs), None))


def _none_yet(campaign: str, noun: str, newest: Job | None) -> NotFoundError:
    if newest is None:
        return NotFoundError(f"campaign {campaign} has no {noun}", where=campaign, remedy="order one, and wait")
    why = f": {newest.error}" if newest.error else ""
    remedy = "order it again" if newest.ended else f"wait until job {newest.id} has ended"
    return NotFoundError(f"the {noun} of campaign {campaign} is {newest.state}{why}", where=campaign, remedy=remedy)


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
