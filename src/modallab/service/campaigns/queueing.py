"""The queue of a rig, for those who ask: runs are queued after the looks that a run has when it begins."""

from collections.abc import Sequence

from modallab.acquisition.procedures.burst import longest_burst_s
from modallab.acquisition.process.trip import TripLatch
from modallab.core.documents.messages import QueueChanged
from modallab.core.documents.queue import ConsentRequest, QueueItem, QueueItemRequest, QueueView
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.service.campaigns.run_start import require_plan
from modallab.service.context import Service
from modallab.service.errors import ConflictError
from modallab.service.records.archive import ArchivedRecords
from modallab.service.records.event_log import EventTopic
from modallab.service.records.run_queue import RunQueue
from modallab.service.rigs.control import ControllerState
from modallab.service.rigs.queue_runner import reason_not_to_begin
from modallab.storage.durable import planned_blocks

HIT_S = 15.0
"""From one good hit to the next: rest, the hammer, and the block."""
ENDED = 50


def queue_run(service: Service, rig: ControllerState, new: QueueItemRequest, operator: str) -> QueueItem:
    """Queue a run.

    Raises:
        NotFoundError: no such campaign.
        ConflictError: the campaign is of another rig, or archived or deleted; or too many wait.
        PlanError: the plan is not possible on this rig.
    """
    campaign = service.repository.campaign(new.campaign)
    if campaign.rig != rig.id:
        raise ConflictError(
            f"campaign {campaign.id} is of rig {campaign.rig}, not of {rig.id}", where="campaign", remedy="name another"
        )
    ArchivedRecords(service.engine).require_present(new.campaign)
    require_plan(new.plan, rig)
    item = RunQueue(service.engine).add(rig.id, new, duration_s(new.plan), operator)
    _notify_queue(service, rig.id, item=item.id, state=item.state, operator=operator)
    return item


def queue_view(service: Service, rig: ControllerState, *, ended: bool = False) -> QueueView:
    """The queue of a rig as it stands; with `ended` the items that have ended too, the newest first."""
    queue = RunQueue(service.engine)
    items, paused = queue.open(rig.id), queue.paused()
    consent = service.control.consent_view(rig.id)
    waiting = next((item for item in items if item.state == "waiting"), None)
    trip = TripLatch(service.folder, rig.bench).read()
    return QueueView(
        rig=rig.id,
        paused=rig.id in paused,
        reason=paused.get(rig.id, ""),
        waits_for="" if waiting is None else reason_not_to_begin(waiting, rig, trip, consent),
        consent=consent,
        remaining_s=sum(item.estimated_s for item in items),
        items=(*items, *(queue.ended(rig.id, ENDED) if ended else ())),
    )


def skip_item(service: Service, rig: str, item: str, reason: str, operator: str) -> QueueItem:
    """Remove a waiting item. Raises as `RunQueue.skip`."""
    skipped = RunQueue(service.engine).take_out(rig, item, reason, operator)
    _notify_queue(service, rig, item=item, state="skipped", reason=reason, operator=operator)
    return skipped


def reorder_items(service: Service, rig: str, items: Sequence[str], operator: str) -> None:
    """Set the order of the waiting runs. Raises as `RunQueue.reorder`."""
    RunQueue(service.engine).reorder(rig, items, operator)
    _notify_queue(service, rig, state="reordered", operator=operator)


def pause_queue(service: Service, rig: str, reason: str, operator: str) -> None:
    """Have nothing begin; a run that is on goes on."""
    RunQueue(service.engine).pause(rig, reason or f"by {operator}", operator)
    _notify_queue(service, rig, state="paused", reason=reason, operator=operator)


def resume_queue(service: Service, rig: str, lease: str | None) -> None:
    """Let the queue go on.

    Raises:
        LeaseNeededError: only who holds the rig may.
    """
    operator = service.leases.require(rig, lease).operator
    RunQueue(service.engine).resume(rig, operator)
    _notify_queue(service, rig, state="resumed", operator=operator)


def give_consent(service: Service, rig: str, new: ConsentRequest, lease: str | None) -> None:
    """Let items that wait begin by themselves.

    Raises:
        LeaseNeededError: only who holds the rig may.
        ConflictError: an item that does not wait.
    """
    waiting = tuple(item.id for item in RunQueue(service.engine).open(rig) if item.state == "waiting")
    foreign = sorted(set(new.items or ()) - set(waiting))
    if foreign:
        raise ConflictError(f"item {foreign[0]} is not waiting", where="items", remedy="read the queue again")
    given = service.control.give_consent(rig, new, waiting if new.items is None else new.items, lease)
    _notify_queue(service, rig, state="consent", operator=given.operator, drive=given.drive, at_bench=given.at_bench)


def duration_s(plan: Plan) -> float:
    """About how long a run takes, in s: of a driven test what its plan asks for, without bursts that are repeated."""
    if isinstance(plan, ImpactPlan):
        return planned_blocks(plan) * (plan.block_s + HIT_S)
    if isinstance(plan, SinePlan):
        return planned_blocks(plan) * (longest_burst_s(plan) + plan.wait_s)
    wave_s = plan.settle_s + plan.blocks * plan.block_s + plan.ramp_s
    return len(plan.levels_v) * (wave_s + plan.wait_s)


def _notify_queue(service: Service, rig: str, **content: str | bool) -> None:
    event = QueueChanged.model_validate({"rig": rig} | content)
    service.log.append(event.kind, EventTopic(rig=rig), event.content())
