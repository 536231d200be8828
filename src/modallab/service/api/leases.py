"""The lease of a rig: who may command it."""

from fastapi import Response

from modallab.core.documents.rigs import Lease, LeaseHolder
from modallab.service.api.bodies import NewLease
from modallab.service.api.problems import documented
from modallab.service.api.request_context import LeaseId, ServiceOf
from modallab.service.api.rigs import state_of
from modallab.service.api.router import ONCE, make_router
from modallab.service.errors import LeaseHeldError, NotFoundError

router = make_router("lease")


@router.post("/rigs/{rig}/lease", status_code=201, dependencies=ONCE, responses=documented(404, 409, 507))
def take_lease(rig: str, new: NewLease, service: ServiceOf) -> Lease:
    """Take the lease of a rig, if nobody holds it; with `take_over` from its holder, if no run is on."""
    state = state_of(service, rig)
    if new.take_over and state.run is not None:
        raise LeaseHeldError(
            f"run {state.run} is on, under the lease of another",
            where=rig,
            remedy="wait for its end, or stop it in an emergency, which needs no lease; then take over",
        )
    return service.leases.take(state.id, new.operator, new.ttl_s, take_over=new.take_over)


@router.put("/rigs/{rig}/lease", responses=documented(404, 507))
def renew_lease(rig: str, service: ServiceOf, lease: LeaseId = None) -> Lease:
    """Begin the lease's time anew."""
    return service.leases.renew(state_of(service, rig).id, lease or "")


@router.delete("/rigs/{rig}/lease", status_code=204, responses=documented(404, 507))
def release_lease(rig: str, service: ServiceOf, lease: LeaseId = None) -> Response:
    """Give the lease back."""
    service.leases.release(state_of(service, rig).id, lease or "")
    return Response(status_code=204)


@router.get("/rigs/{rig}/lease", responses=documented(404))
def get_lease(rig: str, service: ServiceOf) -> LeaseHolder:
    """Who holds the rig."""
    holder = service.leases.holder(state_of(service, rig).id)
    if holder is None:
        raise NotFoundError("nobody holds it", where=rig, remedy="take the lease")
    return holder
