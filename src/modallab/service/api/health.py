"""Whether the service can work, for a watchdog; counters, for a monitor."""

import shutil
from collections.abc import Mapping

from fastapi import APIRouter, Request, Response
from fastapi.responses import PlainTextResponse
from sqlalchemy import func, select

from modallab import __version__
from modallab.core.documents.pages import Health, ServiceFault
from modallab.core.settings import Settings
from modallab.service.api.events import EventFeed
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import OPEN
from modallab.service.context import Service
from modallab.service.rigs.control import ControllerState
from modallab.storage.engine import read_transaction
from modallab.storage.tables import BLOCKS, RUNS

USABLE = ("idle", "running")


Family = Mapping[str, float]
"""Labels of a sample, as Prometheus writes them, and its value."""


def metric_families(service: Service) -> dict[str, Family]:
    """Families of samples by name."""
    with read_transaction(service.engine) as connection:
        runs = connection.execute(select(RUNS.c.state, func.count()).group_by(RUNS.c.state)).all()
        blocks = connection.execute(select(BLOCKS.c.accepted, func.count()).group_by(BLOCKS.c.accepted)).all()
    return {
        "modallab_runs": {_label_text("state", state): count for state, count in runs},
        "modallab_blocks": {_label_text("accepted", int(accepted)): count for accepted, count in blocks},
        "modallab_events": {"": service.log.newest_number()},
        "modallab_free_bytes": {"": shutil.disk_usage(service.folder).free},
        "modallab_rig_usable": {
            _label_text("rig", state.id): state.state in USABLE for state in service.control.states()
        },
    }


def _label_text(name: str, value: object) -> str:
    escaped = str(value).replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'{{{name}="{escaped}"}}'


def _family_text(name: str, family: Family) -> str:
    # The type of a family stands once, before all its samples; a family without any is left out.
    lines = [f"{name}{labels} {float(value)!r}\n" for labels, value in family.items()]
    return f"# TYPE {name} gauge\n{''.join(lines)}" if lines else ""


router = APIRouter(tags=["health"], responses=documented_responses(403, 405, 413, 422, 500, 503))


@router.get("/health", openapi_extra=OPEN)
def get_health(service: ServiceOf, request: Request, response: Response) -> Health:
    """Whether rigs and database can be used, with faults, their start and remedies. Needs no token."""
    states = service.control.states()
    feed: EventFeed = request.app.state.feed
    troubles = [_rig_trouble(state) for state in states if state.state not in USABLE]
    if feed.unread_since:
        troubles.append(_database_trouble(feed.unread_since))
    response.headers["Cache-Control"] = "no-store"
    return Health(
        status="degraded" if troubles else "good",
        version=__version__,
        rigs={state.id: str(state.state) for state in states},
        free_bytes=shutil.disk_usage(service.folder).free,
        troubles=tuple(troubles),
        emergency_stop=stop_url(request),
    )


def _rig_trouble(state: ControllerState) -> ServiceFault:
    if state.state == "starting":
        return ServiceFault(
            part=f"rig {state.id}", what="its bench is being opened", since_utc=state.since, remedy="wait"
        )
    # Where the device or the server stands is for those with the token.
    return ServiceFault(
        part=f"rig {state.id}",
        what="its bench cannot be opened",
        since_utc=state.since,
        remedy="check its cables and its address; the resource of the rig has the error",
    )


def _database_trouble(since: str) -> ServiceFault:
    return ServiceFault(
        part="database",
        what="the database does not answer",
        since_utc=since,
        remedy="check the database server or its disk; the service continues once the database answers",
    )


def stop_url(request: Request) -> str:
    """Where the emergency stop is reached by whoever sent this request."""
    settings: Settings = request.app.state.settings
    name = request.url.hostname or settings.host
    return (
        settings.stop_url
        or f"{settings.scheme}://{f'[{name}]' if ':' in name else name}:{settings.stop_port}/emergency-stop"
    )


@router.get("/metrics", response_class=PlainTextResponse, responses=documented_responses(401))
def get_metrics(service: ServiceOf, request: Request) -> PlainTextResponse:
    """Counters and gauges in Prometheus' text format."""
    feed: EventFeed = request.app.state.feed
    families = metric_families(service) | {"modallab_event_listeners": {"": feed.listeners}}
    text = "".join(_family_text(name, family) for name, family in families.items())
    return PlainTextResponse(text, media_type="text/plain; version=0.0.4")
