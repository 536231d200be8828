"""What a route needs: a role, a rig that the token is for, and a lease that is the caller's own."""

from typing import Any

from fastapi import Request

from modallab.core.documents.users import RANK, Role
from modallab.core.errors import UnknownJobError
from modallab.service.api.request_context import LEASE, caller_of
from modallab.service.context import Service
from modallab.service.errors import LeaseNeededError, NotFoundError, RoleNeededError
from modallab.service.records.callers import Caller

ROLE = "x-role"
ANY_RIG = "x-any-rig"
READS = frozenset({"GET", "HEAD"})


def role_needed(role: Role, *, any_rig: bool = False) -> dict[str, Any]:
    """For the `openapi_extra` of a route that needs another role than is usual for its method.

    With `any_rig` it may be asked of every rig, whatever rigs the token is for.
    """
    return {ROLE: role} | ({ANY_RIG: True} if any_rig else {})


def declared_role(methods: set[str], extra: dict[str, Any]) -> dict[str, Any]:
    """What stands of a route's role in the document: who only reads is an observer, unless the route says otherwise."""
    if extra.get("security") == []:
        return extra
    role = extra.get(ROLE) or ("observer" if methods <= READS else "operator")
    # OpenAPI 3.1 names roles here for schemes that have no scopes.
    return extra | {ROLE: role, "security": [{"token": [role]}, {"session": [role]}]}


def require_role(request: Request, extra: dict[str, Any]) -> bool:
    """Reject who may not ask this, as far as is known without the database; whether `require_own` is to look further.

    Raises:
        RoleNeededError: the caller's role is too low.
    """
    role: Role | None = extra.get(ROLE)
    if role is None:
        return False
    caller = caller_of(request)
    if RANK[caller.role] < RANK[role]:
        raise RoleNeededError(
            f"this needs the role {role}; {caller.name or 'this token'} is {caller.role}",
            remedy="ask somebody with that role, or an admin for another token",
        )
    return role != "observer" and bool(caller.rigs or caller.name)


def require_own(request: Request, extra: dict[str, Any]) -> None:
    """Reject who works at another rig than the token is for, or with the lease of another.

    Raises:
        RoleNeededError: the token is for other rigs.
        LeaseNeededError: the lease that was sent is somebody else's.
        StorageError: it cannot be looked up.
    """
    caller = caller_of(request)
    service: Service = request.app.state.service
    if caller.rigs and ANY_RIG not in extra:
        named = request.path_params if request.path_params else dict(request.query_params)
        require_rig(caller, _rig_of(service, named))
    _require_own_lease(service, caller, request.headers.get(LEASE))


def require_rig(caller: Caller, rig: str | None) -> None:
    """Reject who may not work at a rig.

    Raises:
        RoleNeededError: the token is for other rigs.
    """
    if caller.rigs and rig is not None and rig not in caller.rigs:
        raise RoleNeededError(
            f"this token is for {', '.join(caller.rigs)}, not for {rig}",
            where=rig,
            remedy="ask an admin for a token for this rig",
        )


def _require_own_lease(service: Service, caller: Caller, lease: str | None) -> None:
    # Who has the service's own token says himself who he is.
    if not lease or not caller.name:
        return
    owner = service.leases.owner(lease)
    if owner is not None and owner != caller.name:
        raise LeaseNeededError(f"this lease is {owner}'s", remedy="take the lease yourself")


def _rig_of(service: Service, named: dict[str, Any]) -> str | None:
    """The rig that an address concerns; None if it concerns none, or names what is not there."""
    if "rig" in named:
        return str(named["rig"])
    try:
        if "run" in named:
            entry = service.repository.entry(str(named["run"]))
            return None if entry is None else entry.rig
        campaign = named.get("campaign") or service.repository.campaign_of_job(str(named.get("job", "")))
        return service.repository.campaign(str(campaign)).rig if campaign else None
    except (NotFoundError, UnknownJobError):
        return None
