"""The queue of runs of a rig."""

from typing import Annotated

from fastapi import Body, Query
from fastapi.openapi.models import Example

from modallab.core.documents.queue import (
    ConsentRequest,
    QueueItem,
    QueueItemRequest,
    QueueOrder,
    QueueReason,
    QueueView,
)
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import LeaseId, Operator, ServiceOf
from modallab.service.api.rigs import process_state
from modallab.service.api.router import ONCE, make_router
from modallab.service.campaigns import queueing

router = make_router("queue")
NewItem = Annotated[
    QueueItemRequest,
    Body(
        openapi_examples={
            "impact test": Example(
                value={"campaign": "c20260101T120000-0a1b2c3d", "plan": {"kind": "impact", "points": [10, 6, 3]}}
            )
        }
    ),
]
NewOrder = Annotated[QueueOrder, Body(openapi_examples={"two": Example(value={"items": ["q2", "q1"]})})]
NewConsent = Annotated[
    ConsentRequest,
    Body(
        openapi_examples={
            "the shaker may start": Example(value={"drive": True}),
            "I am at the bench": Example(value={"at_bench": True, "for_s": 3600}),
        }
    ),
]
Why = Annotated[QueueReason | None, Body(openapi_examples={"why": Example(value={"reason": "the clamp is loose"})})]
Ended = Annotated[bool, Query(description="Whether to list the newest 50 ended items too.")]
_CHANGES = documented_responses(404, 409, 507)


@router.get("/rigs/{rig}/queue", responses=documented_responses(404))
def get_queue(rig: str, service: ServiceOf, ended: Ended = False) -> QueueView:
    """The active and the waiting runs of a rig, and what the next one waits for."""
    return queueing.queue_view(service, process_state(service, rig), ended=ended)


@router.post("/rigs/{rig}/queue", status_code=201, dependencies=ONCE, responses=_CHANGES)
def queue_run(rig: str, new: NewItem, service: ServiceOf, operator: Operator) -> QueueItem:
    """Add a run to the end of the queue; needs no lease. It starts automatically only with the consent of the lease's
    holder."""
    return queueing.queue_run(service, process_state(service, rig), new, operator)


@router.put("/rigs/{rig}/queue/order", responses=_CHANGES)
def reorder_queue(rig: str, order: NewOrder, service: ServiceOf, operator: Operator) -> QueueView:
    """Set the order of the waiting runs."""
    queueing.reorder_items(service, process_state(service, rig).id, order.items, operator)
    return queueing.queue_view(service, process_state(service, rig))


@router.put("/rigs/{rig}/queue/consent", responses=_CHANGES)
def consent_to_queue(rig: str, new: NewConsent, service: ServiceOf, lease: LeaseId = None) -> QueueView:
    """Permit waiting items to start automatically; needs the rig's lease, and ends with it."""
    queueing.give_consent(service, process_state(service, rig).id, new, lease)
    return queueing.queue_view(service, process_state(service, rig))


@router.delete("/rigs/{rig}/queue/consent", responses=_CHANGES)
def withdraw_consent(rig: str, service: ServiceOf) -> QueueView:
    """Withdraw the consent: nothing starts automatically. Needs no lease."""
    service.control.withdraw_consent(process_state(service, rig).id)
    return queueing.queue_view(service, process_state(service, rig))


@router.post("/rigs/{rig}/queue/pause", dependencies=ONCE, responses=_CHANGES)
def pause_queue(rig: str, service: ServiceOf, operator: Operator, why: Why = None) -> QueueView:
    """Pause the queue: no run starts, an active run continues. Needs no lease."""
    queueing.pause_queue(service, process_state(service, rig).id, "" if why is None else why.reason, operator)
    return queueing.queue_view(service, process_state(service, rig))


@router.post("/rigs/{rig}/queue/resume", dependencies=ONCE, responses=_CHANGES)
def resume_queue(rig: str, service: ServiceOf, lease: LeaseId = None) -> QueueView:
    """Resume the queue; needs the rig's lease."""
    queueing.resume_queue(service, process_state(service, rig).id, lease)
    return queueing.queue_view(service, process_state(service, rig))


@router.post("/rigs/{rig}/queue/{item}/skip", dependencies=ONCE, responses=_CHANGES)
def skip_item(rig: str, item: str, service: ServiceOf, operator: Operator, why: Why = None) -> QueueItem:
    """Remove a waiting item."""
    return queueing.skip_item(
        service, process_state(service, rig).id, item, "" if why is None else why.reason, operator
    )
