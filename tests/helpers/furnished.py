"""A service that has something of everything: campaigns, a run with blocks, its model, jobs, users, a queue."""

import time
from pathlib import Path

from lab import RIG, Lab

from modallab.core.documents.queue import QueueItemRequest
from modallab.core.documents.results import JobRequest
from modallab.core.documents.runs import RunRequest
from modallab.core.documents.users import TokenRequest, UserRequest
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.jobs.job import JobDefinition
from modallab.jobs.leases import JobLeases
from modallab.pipelines.job_kinds import campaigns_of, kinds
from modallab.service.api.rigs import process_state
from modallab.service.campaigns.queueing import queue_run
from modallab.service.campaigns.run_start import begin_run
from modallab.service.jobs.campaign_jobs import order_job
from modallab.service.records.users import UserTable
from modallab.storage.engine import name_database

URL = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"


def furnish(folder: Path, rig: Rig, database: str | None = None) -> Lab:
    """Open a service on `folder` and fill it: a run of three points with its model, a job that waits.

    With a database the catalogue is there.
    """
    if database is not None:
        name_database(folder, database)
    lab = Lab(folder, rig, URL)
    try:
        lab.wait_until_idle()
        campaign = lab.campaign("with a model")
        lab.campaign("with nothing")
        lease = lab.lease()
        run = begin_run(lab.service, campaign, RunRequest(plan=ImpactPlan(points=(10, 6, 3), hits=2)), lease.id)
        lab.wait_for_ended(run)
        lab.wait_until_idle()
        lab.service.leases.release(RIG, lease.id)
        _compute(lab)
        order_job(lab.service, campaign, "report", JobRequest(), "Ada")
        _let_people_in(lab)
        new = QueueItemRequest(campaign=campaign, plan=ImpactPlan(points=(10,)))
        queue_run(lab.service, process_state(lab.service, RIG), new, "Ada")
    except BaseException:
        lab.close()
        raise
    return lab


def _let_people_in(lab: Lab) -> None:
    users = UserTable(lab.service.engine)
    for name in ("Olga", "Otto"):
        users.add(UserRequest(name=name), "Ada")
        users.make_token(name, TokenRequest(), "Ada")


def _compute(lab: Lab) -> None:
    """What waits is computed here, as a runner and its worker would."""
    known = {kind.name: kind for kind in kinds(campaigns_of(lab.store), lab.store.folder)}
    # Ordered by itself after the run's end.
    while not lab.service.jobs.list().jobs:
        time.sleep(0.02)
    leases = JobLeases(lab.service.engine, "furnisher")
    for taken in leases.lease_jobs(known, 10):
        kind: JobDefinition = known[taken.job.kind]
        computed = kind.compute(kind.load(dict(taken.job.parameters), taken.job.inputs), lambda *_: None)
        assert leases.complete(taken, kind.keep(taken.attempt_name, computed))
