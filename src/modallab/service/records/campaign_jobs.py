"""Which jobs are of which campaign."""

from sqlalchemy import Engine, insert, select

from modallab.jobs import Job
from modallab.service.records import audit
from modallab.service.records.database import writing
from modallab.storage.service_tables import CAMPAIGN_JOBS


def remember(engine: Engine, campaign: str, job: Job, operator: str) -> None:
    """Keep that a job is of a campaign; nothing to do if that is known."""
    mine = CAMPAIGN_JOBS.c.campaign == campaign, CAMPAIGN_JOBS.c.job == job.id
    with writing(engine) as connection:
        if connection.scalar(select(CAMPAIGN_JOBS.c.job).where(*mine)) is not None:
            return
        connection.execute(insert(CAMPAIGN_JOBS).values(campaign=campaign, job=job.id, kind=job.kind))
        audit.note(connection, operator, f"order-{job.kind}", campaign, {"job": job.id, "runs": list(job.inputs)})
