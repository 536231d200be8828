"""Revisions of a rig: what it was believed to be, since when, and another one."""

from typing import Annotated

from fastapi import Path

from modallab.core.documents.pages import Page
from modallab.core.documents.rigs import RigRevision, RigRevisionNew, RigView
from modallab.core.rig import Rig
from modallab.service.api.problems import documented
from modallab.service.api.request_context import LeaseId, ServiceOf
from modallab.service.api.rigs import rig_view, state_of
from modallab.service.api.router import ONCE, make_router
from modallab.service.records.rig_revisions import RigRevisions

router = make_router("rigs")
Number = Annotated[int, Path(ge=1, lt=2**31, description="From 1.")]


@router.get("/rigs/{rig}/revisions", responses=documented(404))
def list_rig_revisions(rig: str, service: ServiceOf) -> Page[RigRevision]:
    """What a rig was believed to be, the oldest first."""
    return Page(items=RigRevisions(service.engine).all(state_of(service, rig).id))


@router.get("/rigs/{rig}/revisions/{number}", responses=documented(404))
def get_rig_revision(rig: str, number: Number, service: ServiceOf) -> Rig:
    """A description that the rig has had."""
    return RigRevisions(service.engine).description(state_of(service, rig).id, number)


@router.post("/rigs/{rig}/revisions", status_code=201, dependencies=ONCE, responses=documented(404, 409, 507))
def revise_rig(rig: str, new: RigRevisionNew, service: ServiceOf, lease: LeaseId = None) -> RigView:
    """Go on with another description of what stands on the bench, which is opened anew; needs the rig's lease."""
    service.control.revise(state_of(service, rig).id, new.description, new.reason, lease)
    return rig_view(service, state_of(service, rig))
