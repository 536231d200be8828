"""An operator's word on a block: it counts, or it does not."""

from modallab.core.documents.runs import Drop, Verdict
from modallab.service.campaigns.runs import block_record, record_of
from modallab.service.context import Service
from modallab.service.errors import ConflictError
from modallab.service.records import audit
from modallab.service.records.event_log import Topic
from modallab.storage.recorder import utc_now
from modallab.storage.records import ENDED


def judge(service: Service, run: str, n: int, verdict: Verdict, lease: str | None) -> None:
    """Accept or reject a block of a run, going on or ended.

    Raises:
        NotFoundError: there is no such block.
        LeaseNeededError: not without the lease of the run's rig.
        ConflictError: the run belongs to no campaign, or a block is accepted while the run still asks for it again.
    """
    block, record, entry = block_record(service, run, n), record_of(service, run), service.repository.entry(run)
    if entry is None:
        raise ConflictError(
            f"run {run} belongs to no campaign of this service", where=run, remedy="use its own program"
        )
    operator = service.leases.require(entry.rig, lease).operator
    if record.state not in ENDED:
        _while_running(service, entry.rig, run, n, verdict, lease)
        return
    if block.note.accepted == verdict.accepted:
        return
    word = "accepted" if verdict.accepted else "rejected"
    service.store.catalogue.judge_block(
        run, n, accepted=verdict.accepted, reason=verdict.reason or word, operator=operator, utc=utc_now()
    )
    audit.enter(service.engine, operator, "verdict", f"{run}/{n}", verdict.model_dump())
    content = {"kind": "verdict", "run": run, "n": n, "operator": operator} | verdict.model_dump()
    service.log.append("verdict", Topic(entry.rig, entry.campaign, run), content)


def _while_running(service: Service, rig: str, run: str, n: int, verdict: Verdict, lease: str | None) -> None:
    if verdict.accepted:
        raise ConflictError(
            "a block can be accepted only when its run has ended", where=run, remedy="wait; the hit is asked for again"
        )
    service.control.command(rig, run, Drop(n=n, reason=verdict.reason or "rejected by the operator"), lease)
