"""Rigs: how they stand, emergency stop, reset, and the lease: who may command one."""

from typing import Annotated

from fastapi import Body, Response
from fastapi.openapi.models import Example

from modallab.acquisition.process.trip import TripLatch
from modallab.core.documents.pages import Page
from modallab.core.documents.rigs import Lease, LeaseHolder, LeaseNew, RigView, StopReason, Trip
from modallab.core.rig import Rig
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import CallerOf, LeaseId, Operator, ServiceOf
from modallab.service.api.roles import role_needed
from modallab.service.api.router import ONCE, make_router
from modallab.service.context import Service
from modallab.service.errors import LeaseHeldError, NotFoundError
from modallab.service.records.callers import UNKNOWN
from modallab.service.rigs.control import ControllerState
from modallab.storage import rig_hash

router = make_router("rigs")
NewLease = Annotated[
    LeaseNew, Body(openapi_examples={"for ten minutes": Example(value={"operator": "Ada", "ttl_s": 600})})
]
Reason = Annotated[StopReason | None, Body(openapi_examples={"why": Example(value={"reason": "loose cable"})})]


@router.get("/rigs")
def list_rigs(service: ServiceOf) -> Page[RigView]:
    """All rigs of this service."""
    return Page(items=tuple(rig_view(service, state) for state in service.control.states()))


@router.get("/rigs/{rig}", responses=documented_responses(404))
def get_rig(rig: str, service: ServiceOf) -> RigView:
    """How a rig stands."""
    return rig_view(service, state_of(service, rig))


@router.get("/rigs/{rig}/description", responses=documented_responses(404))
def get_description(rig: str, service: ServiceOf) -> Rig:
    """What stands on the bench, as in the rig file."""
    return state_of(service, rig).rig


@router.post(
    "/rigs/{rig}/emergency-stop",
    dependencies=ONCE,
    responses=documented_responses(404, 409),
    openapi_extra=role_needed("observer", any_rig=True),
)
def stop_rig(rig: str, service: ServiceOf, operator: Operator, stop: Reason = None) -> RigView:
    """Bring the output to 0 V and latch the rig. Needs no lease. This is not a safety-rated stop."""
    reason = "" if stop is None else stop.reason
    service.control.emergency_stop(state_of(service, rig).id, reason or "asked for by the operator", operator)
    return rig_view(service, state_of(service, rig))


@router.post("/rigs/{rig}/reset", dependencies=ONCE, responses=documented_responses(404, 409))
def reset_rig(rig: str, service: ServiceOf, lease: LeaseId = None, why: Reason = None) -> RigView:
    """Let a tripped rig be driven again, after someone has looked at it."""
    service.control.reset(state_of(service, rig).id, "" if why is None else why.reason, lease)
    return rig_view(service, state_of(service, rig))


def state_of(service: Service, rig: str) -> ControllerState:
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
        trip=None if trip is None else Trip(cause=trip.cause, reason=trip.what, utc=trip.utc),
        lease=service.leases.holder(state.id),
        error=state.error,
    )


lease_router = make_router("lease")


@lease_router.post(
    "/rigs/{rig}/lease", status_code=201, dependencies=ONCE, responses=documented_responses(404, 409, 507)
)
def take_lease(rig: str, new: NewLease, service: ServiceOf, caller: CallerOf, operator: Operator) -> Lease:
    """Take the lease of a rig, if nobody holds it; with `take_over` from its holder, if no run is on or it is you; with
    `recover` the one you hold already."""
    state = state_of(service, rig)
    name = caller.name or new.operator or operator
    known = name != UNKNOWN
    if new.recover and known:
        return service.leases.recover(state.id, name)
    holder = service.leases.holder(state.id)
    own = known and holder is not None and holder.operator == name
    if new.take_over and state.run is not None and not own:
        raise LeaseHeldError(
            f"run {state.run} is on, under the lease of another",
            where=rig,
            remedy="wait for its end, or stop it in an emergency, which needs no lease; then take over",
        )
    return service.leases.take(state.id, name, new.ttl_s, take_over=new.take_over)


@lease_router.put("/rigs/{rig}/lease", responses=documented_responses(404, 507))
def renew_lease(rig: str, service: ServiceOf, lease: LeaseId = None) -> Lease:
    """Begin the lease's time again."""
    return service.leases.renew(state_of(service, rig).id, lease or "")


@lease_router.delete("/rigs/{rig}/lease", status_code=204, responses=documented_responses(404, 507))
def release_lease(rig: str, service: ServiceOf, lease: LeaseId = None) -> Response:
    """Release the lease."""
    service.leases.release(state_of(service, rig).id, lease or "")
    return Response(status_code=204)


@lease_router.get("/rigs/{rig}/lease", responses=documented_responses(404))
def get_lease(rig: str, service: ServiceOf) -> LeaseHolder:
    """Who holds the rig."""
    holder = service.leases.holder(state_of(service, rig).id)
    if holder is None:
        raise NotFoundError("nobody holds it", where=rig, remedy="take the lease")
    return holder
