"""Rigs: how they stand, emergency stop, reset."""

from modallab.acquisition.process.trip import TripLatch
from modallab.core.documents.pages import Page
from modallab.core.documents.rigs import RigView, Trip
from modallab.core.rig import Rig
from modallab.service.api.bodies import Reason
from modallab.service.api.problems import documented
from modallab.service.api.request_context import LeaseId, Operator, ServiceOf
from modallab.service.api.router import ONCE, make_router
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.rigs.control import ControllerState
from modallab.storage import rig_hash

router = make_router("rigs")


@router.get("/rigs")
def list_rigs(service: ServiceOf) -> Page[RigView]:
    """All rigs of this service."""
    return Page(items=tuple(_view(service, state) for state in service.control.states()))


@router.get("/rigs/{rig}", responses=documented(404))
def get_rig(rig: str, service: ServiceOf) -> RigView:
    """How a rig stands."""
    return _view(service, state_of(service, rig))


@router.get("/rigs/{rig}/description", responses=documented(404))
def get_description(rig: str, service: ServiceOf) -> Rig:
    """What stands on the bench, as in the rig file."""
    return state_of(service, rig).rig


@router.post("/rigs/{rig}/emergency-stop", dependencies=ONCE, responses=documented(404, 409))
def stop_rig(rig: str, service: ServiceOf, operator: Operator, stop: Reason = None) -> RigView:
    """Bring the output to 0 V and latch the rig. Needs no lease. This is not a safety-rated stop."""
    reason = "" if stop is None else stop.reason
    service.control.emergency_stop(state_of(service, rig).id, reason or "asked for by the operator", operator)
    return _view(service, state_of(service, rig))


@router.post("/rigs/{rig}/reset", dependencies=ONCE, responses=documented(404, 409))
def reset_rig(rig: str, service: ServiceOf, lease: LeaseId = None, why: Reason = None) -> RigView:
    """Let a tripped rig be driven again, after someone has looked at it."""
    service.control.reset(state_of(service, rig).id, "" if why is None else why.reason, lease)
    return _view(service, state_of(service, rig))


def state_of(service: Service, rig: str) -> ControllerState:
    """How a rig's process stands.

    Raises:
        NotFoundError: no rig of this id.
    """
    states = {state.id: state for state in service.control.states()}
    if rig not in states:
        raise NotFoundError(f"there is no rig {rig!r}", remedy=f"this service has: {', '.join(states) or 'none'}")
    return states[rig]


def _view(service: Service, state: ControllerState) -> RigView:
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
