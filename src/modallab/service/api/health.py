"""Whether the service can work, for a watchdog; counters, for a monitor."""

import shutil

from fastapi import APIRouter, Request, Response
from fastapi.responses import PlainTextResponse
from sqlalchemy import func, select

from modallab import __version__
from modallab.core.documents.pages import Health, Trouble
from modallab.core.settings import Settings
from modallab.service.api.events import Feed
from modallab.service.api.problems import documented
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import OPEN
from modallab.service.context import Service
from modallab.service.rigs.control import ControllerState
from modallab.storage.engine import reading
from modallab.storage.tables import BLOCKS, RUNS

USABLE = ("idle", "running")


def counters(service: Service) -> dict[str, float]:
    """Name, with labels as Prometheus writes them, and value."""
    found: dict[str, float] = {}
    with reading(service.engine) as connection:
        for state, count in connection.execute(select(RUNS.c.state, func.count()).group_by(RUNS.c.state)):
            found[f'modallab_runs{{state="{state}"}}'] = count
        for accepted, count in connection.execute(select(BLOCKS.c.accepted, func.count()).group_by(BLOCKS.c.accepted)):
            found[f'modallab_blocks{{accepted="{int(accepted)}"}}'] = count
    found["modallab_events"] = service.log.last()
    found["modallab_free_bytes"] = shutil.disk_usage(service.folder).free
    for state in service.control.states():
        found[f'modallab_rig_usable{{rig="{state.id}"}}'] = float(state.state in USABLE)
    return found


router = APIRouter(tags=["health"], responses=documented(403, 405, 413, 422, 500, 503))


@router.get("/health", openapi_extra=OPEN)
def get_health(service: ServiceOf, request: Request, response: Response) -> Health:
    """Whether every rig can be used, and the database; what is wrong, since when, what to do. Needs no token."""
    states = service.control.states()
    feed: Feed = request.app.state.feed
    troubles = [_of_rig(state) for state in states if state.state not in USABLE]
    if feed.unread_since:
        troubles.append(_of_database(feed.unread_since))
    response.headers["Cache-Control"] = "no-store"
    return Health(
        status="degraded" if troubles else "good",
        version=__version__,
        rigs={state.id: str(state.state) for state in states},
        free_bytes=shutil.disk_usage(service.folder).free,
        troubles=tuple(troubles),
        emergency_stop=_stop_url(request),
    )


def _of_rig(state: ControllerState) -> Trouble:
    if state.state == "starting":
        return Trouble(part=f"rig {state.id}", what="its bench is being opened", since_utc=state.since, remedy="wait")
    # Where the device or the server stands is for those with the token.
    return Trouble(
        part=f"rig {state.id}",
        what="its bench cannot be opened",
        since_utc=state.since,
        remedy="look at its cables and its address; the rig itself names the error",
    )


def _of_database(since: str) -> Trouble:
    return Trouble(
        part="database",
        what="it does not answer",
        since_utc=since,
        remedy="look at its server or its disk; the service goes on by itself once it answers",
    )


def _stop_url(request: Request) -> str:
    settings: Settings = request.app.state.settings
    name = request.url.hostname or settings.host
    return settings.stop_url or f"http://{f'[{name}]' if ':' in name else name}:{settings.stop_port}/emergency-stop"


@router.get("/metrics", response_class=PlainTextResponse, responses=documented(401))
def get_metrics(service: ServiceOf, request: Request) -> str:
    """Counters and gauges in Prometheus' text format."""
    feed: Feed = request.app.state.feed
    values = counters(service) | {"modallab_event_listeners": float(feed.listeners)}
    return "".join(f"# TYPE {name.partition('{')[0]} gauge\n{name} {value:g}\n" for name, value in values.items())
