"""Campaigns and runs are archived, deleted with a grace time, and restored."""

from datetime import timedelta

from fastapi import Request

from modallab.core.documents.messages import ArchiveChanged
from modallab.core.documents.runs import CampaignView, RunView
from modallab.core.settings import Settings
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import Operator, ServiceOf
from modallab.service.api.router import ONCE, make_router
from modallab.service.campaigns.runs import record_of, run_view
from modallab.service.context import Service
from modallab.service.records.archive import ArchivedRecords
from modallab.service.records.event_log import EventTopic

router = make_router("archive")
_CHANGES = documented_responses(404, 409, 507)


@router.post("/campaigns/{campaign}/archive", dependencies=ONCE, responses=_CHANGES)
def archive_campaign(campaign: str, service: ServiceOf, operator: Operator) -> CampaignView:
    """Leave a campaign out of lists. It can be read and exported as before; nothing is added until it is restored."""
    ArchivedRecords(service.engine).archive("campaign", campaign, operator)
    return _set_campaign_aside(service, campaign, "archived", operator)


@router.delete("/campaigns/{campaign}", responses=_CHANGES)
def delete_campaign(campaign: str, service: ServiceOf, operator: Operator, request: Request) -> CampaignView:
    """Delete a campaign with its runs. Until `purge_utc` it can be restored."""
    ArchivedRecords(service.engine).delete("campaign", campaign, operator, _grace_of_request(request))
    return _set_campaign_aside(service, campaign, "deleted", operator)


@router.post("/campaigns/{campaign}/restore", dependencies=ONCE, responses=_CHANGES)
def restore_campaign(campaign: str, service: ServiceOf, operator: Operator) -> CampaignView:
    """Restore an archived or deleted campaign."""
    ArchivedRecords(service.engine).restore("campaign", campaign, operator)
    return _set_campaign_aside(service, campaign, "restored", operator)


@router.post("/runs/{run}/archive", dependencies=ONCE, responses=_CHANGES)
def archive_run(run: str, service: ServiceOf, operator: Operator) -> RunView:
    """Leave a run out of lists, and out of results of its campaign unless it is named."""
    record_of(service, run)
    ArchivedRecords(service.engine).archive("run", run, operator)
    return _set_run_aside(service, run, "archived", operator)


@router.delete("/runs/{run}", responses=_CHANGES)
def delete_run(run: str, service: ServiceOf, operator: Operator, request: Request) -> RunView:
    """Delete a run that has ended. Until `purge_utc` it can be restored."""
    record_of(service, run)
    ArchivedRecords(service.engine).delete("run", run, operator, _grace_of_request(request))
    return _set_run_aside(service, run, "deleted", operator)


@router.post("/runs/{run}/restore", dependencies=ONCE, responses=_CHANGES)
def restore_run(run: str, service: ServiceOf, operator: Operator) -> RunView:
    """Restore an archived or deleted run."""
    record_of(service, run)
    ArchivedRecords(service.engine).restore("run", run, operator)
    return _set_run_aside(service, run, "restored", operator)


def _grace_of_request(request: Request) -> timedelta:
    settings: Settings = request.app.state.settings
    return timedelta(days=settings.grace_days)


def _set_campaign_aside(service: Service, campaign: str, state: str, operator: str) -> CampaignView:
    view = service.repository.campaign(campaign)
    event = ArchiveChanged(campaign=campaign, state=state, operator=operator)
    service.log.append(event.kind, EventTopic(view.rig, campaign), event.model_dump())
    return view


def _set_run_aside(service: Service, run: str, state: str, operator: str) -> RunView:
    view = run_view(service, run)
    event = ArchiveChanged(run=run, state=state, operator=operator)
    service.log.append(event.kind, EventTopic(view.rig or "", view.campaign or "", run), event.model_dump())
    return view
