"""Revisions of a rig: what it was believed to be, since when, and another one."""

from datetime import UTC, datetime
from typing import Annotated

from fastapi import Path

from modallab.core.documents.pages import Page
from modallab.core.documents.rigs import RigRevision, RigRevisionNew, RigView
from modallab.core.rig import Rig
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import LeaseId, ServiceOf
from modallab.service.api.rigs import rig_view, state_of
from modallab.service.api.router import ONCE, make_router
from modallab.service.context import Service
from modallab.service.errors import ConflictError
from modallab.service.jobs.results import diagnosis_of_campaign
from modallab.service.records.rig_revisions import RigRevisions
from modallab.service.rigs.control import ControllerState

router = make_router("rigs")
REASON = 400
Number = Annotated[int, Path(ge=1, lt=2**31, description="From 1.")]


@router.get("/rigs/{rig}/revisions", responses=documented_responses(404))
def list_rig_revisions(rig: str, service: ServiceOf) -> Page[RigRevision]:
    """What a rig was believed to be, the oldest first."""
    return Page(items=RigRevisions(service.engine).all(state_of(service, rig).id))


@router.get("/rigs/{rig}/revisions/{number}", responses=documented_responses(404))
def get_rig_revision(rig: str, number: Number, service: ServiceOf) -> Rig:
    """A description that the rig has had."""
    return RigRevisions(service.engine).description(state_of(service, rig).id, number)


@router.post("/rigs/{rig}/revisions", status_code=201, dependencies=ONCE, responses=documented_responses(404, 409, 507))
def revise_rig(rig: str, new: RigRevisionNew, service: ServiceOf, lease: LeaseId = None) -> RigView:
    """Go on with another description of what stands on the bench, which is opened again; needs the rig's lease."""
    service.control.revise(state_of(service, rig).id, new.description, new.reason, lease)
    return rig_view(service, state_of(service, rig))


@router.post("/campaigns/{campaign}/gap/apply", dependencies=ONCE, responses=documented_responses(404, 409, 422, 507))
def apply_diagnosis(campaign: str, service: ServiceOf, lease: LeaseId = None) -> RigView:
    """Go on with a rig whose simulation carries what the campaign's newest diagnosis found; needs the rig's lease."""
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.gap.revisions.apply import with_diagnosis

    known = service.repository.campaign(campaign)
    state = state_of(service, known.rig)
    found = diagnosis_of_campaign(service, campaign)
    _require_same(service, state, found.runs)
    revised = with_diagnosis(state.rig, found.diagnosis, datetime.now(UTC).date(), known.name)
    effects = " and ".join(one.effect.replace("_", " ") for one in found.diagnosis.effects)
    reason = f"{effects}, as diagnosed in {known.name}"
    service.control.revise(state.id, revised, reason[:REASON], lease)
    return rig_view(service, state_of(service, state.id))


def _require_same(service: Service, state: ControllerState, runs: tuple[str, ...]) -> None:
    """Reject a diagnosis that was made with another description than the rig has now."""
    if any(service.store.catalogue.run(run).rig != state.rig for run in runs):
        raise ConflictError(
            "the diagnosed runs were recorded with another description of the rig than counts now",
            where=state.id,
            remedy="diagnose a campaign that was recorded with this revision",
        )
