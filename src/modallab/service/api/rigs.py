"""Rigs: how they stand, emergency stop, reset, lease, possible plans, and revisions of what they are believed to be."""

from datetime import UTC, datetime
from typing import Annotated

from fastapi import Body, Path, Response
from fastapi.openapi.models import Example

from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.acquisition.process.trip import TripLatch
from modallab.core.documents.pages import Page
from modallab.core.documents.rigs import (
    Lease,
    LeaseHolder,
    LeaseRequest,
    RigRevision,
    RigRevisionRequest,
    RigView,
    StopReason,
    TripReason,
)
from modallab.core.documents.runs import PlanCheck
from modallab.core.errors import ConfigurationError, PlanError, RigError
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.service.api.access import role_needed
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import CallerOf, LeaseId, Operator, ServiceOf
from modallab.service.api.router import ONCE, make_router
from modallab.service.campaigns.queueing import duration_s
from modallab.service.campaigns.run_start import require_sensible_numbers
from modallab.service.context import Service
from modallab.service.errors import ConflictError, LeaseHeldError, NotFoundError
from modallab.service.jobs.results import diagnosis_of_campaign
from modallab.service.records.rig_revisions import RigRevisions
from modallab.service.records.users import UNKNOWN
from modallab.service.rigs.control import ControllerState
from modallab.storage import rig_hash
from modallab.storage.durable import planned_blocks

router = make_router("rigs")
NewLease = Annotated[
    LeaseRequest, Body(openapi_examples={"for ten minutes": Example(value={"operator": "Ada", "ttl_s": 600})})
]
Reason = Annotated[StopReason | None, Body(openapi_examples={"why": Example(value={"reason": "loose cable"})})]
REASON = 400
Number = Annotated[int, Path(ge=1, lt=2**31, description="From 1.")]


@router.get("/rigs")
def list_rigs(service: ServiceOf) -> Page[RigView]:
    """All rigs of this service."""
    return Page(items=tuple(rig_view(service, state) for state in service.control.states()))


@router.get("/rigs/{rig}", responses=documented_responses(404))
def get_rig(rig: str, service: ServiceOf) -> RigView:
    """State of a rig."""
    return rig_view(service, process_state(service, rig))


@router.get("/rigs/{rig}/description", responses=documented_responses(404))
def get_description(rig: str, service: ServiceOf) -> Rig:
    """The description of the bench, as in the rig file."""
    return process_state(service, rig).rig


@router.post(
    "/rigs/{rig}/emergency-stop",
    dependencies=ONCE,
    responses=documented_responses(404, 409),
    openapi_extra=role_needed("observer", any_rig=True),
)
def stop_rig(rig: str, service: ServiceOf, operator: Operator, stop: Reason = None) -> RigView:
    """Bring the output to 0 V and latch the rig. Needs no lease. This is not a safety-rated stop."""
    reason = "" if stop is None else stop.reason
    service.control.emergency_stop(process_state(service, rig).id, reason or "requested by the operator", operator)
    return rig_view(service, process_state(service, rig))


@router.post("/rigs/{rig}/reset", dependencies=ONCE, responses=documented_responses(404, 409))
def reset_rig(rig: str, service: ServiceOf, lease: LeaseId = None, why: Reason = None) -> RigView:
    """Allow a tripped rig to be driven again, after a check of the bench."""
    service.control.reset(process_state(service, rig).id, "" if why is None else why.reason, lease)
    return rig_view(service, process_state(service, rig))


def process_state(service: Service, rig: str) -> ControllerState:
    """How a rig's process stands.

    Raises:
        NotFoundError: no rig of this id.
    """
    states = {state.id: state for state in service.control.states()}
    if rig not in states:
        raise NotFoundError(f"there is no rig {rig!r}", remedy=f"this service has: {', '.join(states) or 'none'}")
    return states[rig]


def rig_view(service: Service, state: ControllerState) -> RigView:
    """How a rig is shown."""
    trip = TripLatch(service.folder, state.bench).read()
    return RigView(
        id=state.id,
        name=state.rig.name,
        bench=state.bench,
        rig_hash=rig_hash(state.rig),
        state=state.state,
        can_drive=None if state.info is None else state.info.can_drive,
        run=state.run,
        trip=None if trip is None else TripReason(cause=trip.cause, reason=trip.what, utc=trip.utc),
        lease=service.leases.holder(state.id),
        error=state.error,
    )


lease_router = make_router("lease")


@lease_router.post(
    "/rigs/{rig}/lease", status_code=201, dependencies=ONCE, responses=documented_responses(404, 409, 507)
)
def take_lease(rig: str, new: NewLease, service: ServiceOf, caller: CallerOf, operator: Operator) -> Lease:
    """Take the lease of a rig, if it is free. `take_over` takes it from its holder, if no run is active or you are
    the holder; `recover` returns your own lease."""
    state = process_state(service, rig)
    name = caller.name or new.operator or operator
    known = name != UNKNOWN
    if new.recover and known:
        return service.leases.recover(state.id, name)
    holder = service.leases.holder(state.id)
    own = known and holder is not None and holder.operator == name
    if new.take_over and state.run is not None and not own:
        raise LeaseHeldError(
            f"run {state.run} is active, under the lease of another person",
            where=rig,
            remedy="wait for its end, or use the emergency stop, which needs no lease; then take over",
        )
    return service.leases.take(state.id, name, new.ttl_s, take_over=new.take_over)


@lease_router.put("/rigs/{rig}/lease", responses=documented_responses(404, 507))
def renew_lease(rig: str, service: ServiceOf, lease: LeaseId = None) -> Lease:
    """Restart the time of the lease."""
    return service.leases.renew(process_state(service, rig).id, lease or "")


@lease_router.delete("/rigs/{rig}/lease", status_code=204, responses=documented_responses(404, 507))
def release_lease(rig: str, service: ServiceOf, lease: LeaseId = None) -> Response:
    """Release the lease."""
    service.leases.release(process_state(service, rig).id, lease or "")
    return Response(status_code=204)


@lease_router.get("/rigs/{rig}/lease", responses=documented_responses(404))
def get_lease(rig: str, service: ServiceOf) -> LeaseHolder:
    """The holder of the rig's lease."""
    holder = service.leases.holder(process_state(service, rig).id)
    if holder is None:
        raise NotFoundError("nobody holds it", where=rig, remedy="take the lease")
    return holder


@router.post("/rigs/{rig}/plan-checks", responses=documented_responses(404), openapi_extra=role_needed("observer"))
def check_plan(rig: str, plan: Annotated[Plan, Body()], service: ServiceOf) -> PlanCheck:
    """Check whether the rig can run a plan; nothing moves, and no lease is needed."""
    controller = process_state(service, rig)
    try:
        require_sensible_numbers(plan, controller.rig)
        _require_possible(plan, controller)
    except (PlanError, RigError, ConfigurationError) as error:
        return PlanCheck(problems=(error.what,), blocks=0, duration_s=0.0)
    return PlanCheck(problems=(), blocks=planned_blocks(plan), duration_s=duration_s(plan))


def _require_possible(plan: Plan, controller: ControllerState) -> None:
    # A bench that is not open yet says nothing of itself; the run looks again.
    if controller.info is not None:
        require_possible(plan, controller.rig, controller.info)


@router.get("/rigs/{rig}/revisions", responses=documented_responses(404))
def list_rig_revisions(rig: str, service: ServiceOf) -> Page[RigRevision]:
    """All descriptions of a rig, the oldest first."""
    return Page(items=RigRevisions(service.engine).all_revisions(process_state(service, rig).id))


@router.get("/rigs/{rig}/revisions/{number}", responses=documented_responses(404))
def get_rig_revision(rig: str, number: Number, service: ServiceOf) -> Rig:
    """One description of a rig."""
    return RigRevisions(service.engine).description(process_state(service, rig).id, number)


@router.post("/rigs/{rig}/revisions", status_code=201, dependencies=ONCE, responses=documented_responses(404, 409, 507))
def revise_rig(rig: str, new: RigRevisionRequest, service: ServiceOf, lease: LeaseId = None) -> RigView:
    """Replace the description of the bench, which is reopened; needs the rig's lease."""
    service.control.revise(process_state(service, rig).id, new.description, new.reason, lease)
    return rig_view(service, process_state(service, rig))


@router.post("/campaigns/{campaign}/gap/apply", dependencies=ONCE, responses=documented_responses(404, 409, 422, 507))
def apply_diagnosis(campaign: str, service: ServiceOf, lease: LeaseId = None) -> RigView:
    """Add the effects of the campaign's newest diagnosis to the rig's simulation; needs the rig's lease."""
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.gap.revisions import with_diagnosis

    known = service.repository.campaign(campaign)
    state = process_state(service, known.rig)
    found = diagnosis_of_campaign(service, campaign)
    _require_same(service, state, found.runs)
    revised = with_diagnosis(state.rig, found.diagnosis, datetime.now(UTC).date(), known.name)
    effects = " and ".join(one.effect.replace("_", " ") for one in found.diagnosis.effects)
    reason = f"{effects}, as diagnosed in {known.name}"
    service.control.revise(state.id, revised, reason[:REASON], lease)
    return rig_view(service, process_state(service, state.id))


def _require_same(service: Service, state: ControllerState, runs: tuple[str, ...]) -> None:
    """Reject a diagnosis that was made with another description than the rig has now."""
    if any(service.store.catalogue.run(run).rig != state.rig for run in runs):
        raise ConflictError(
            "the rig has been revised since the diagnosed runs",
            where=state.id,
            remedy="diagnose a campaign that was recorded with this revision",
        )
