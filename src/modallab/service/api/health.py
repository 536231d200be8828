"""Whether the service can work, for a watchdog; counters, for a monitor."""

import shutil

from fastapi import APIRouter, Request, Response
from fastapi.responses import PlainTextResponse
from sqlalchemy import func, select

from modallab import __version__
from modallab.core.documents.pages import Health
from modallab.core.errors import StorageError
from modallab.service.api.events import Feed
from modallab.service.api.problems import documented
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import OPEN
from modallab.service.context import Service
from modallab.storage.engine import reading
from modallab.storage.tables import BLOCKS, RUNS


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
        found[f'modallab_rig_usable{{rig="{state.id}"}}'] = float(state.state in ("idle", "running"))
    return found


router = APIRouter(tags=["health"], responses=documented(403, 405, 413, 422, 500, 503))


@router.get("/health", openapi_extra=OPEN)
def get_health(service: ServiceOf, response: Response) -> Health:
    """Whether every rig can be used, and the database. Needs no token."""
    states = {state.id: state.state for state in service.control.states()}
    good = all(state in ("idle", "running") for state in states.values()) and _database_answers(service)
    response.headers["Cache-Control"] = "no-store"
    return Health(
        status="good" if good else "degraded",
        version=__version__,
        rigs={rig: str(state) for rig, state in states.items()},
        free_bytes=shutil.disk_usage(service.folder).free,
    )


def _database_answers(service: Service) -> bool:
    try:
        service.log.last()
    except StorageError:
        return False
    return True


@router.get("/metrics", response_class=PlainTextResponse, responses=documented(401))
def get_metrics(service: ServiceOf, request: Request) -> str:
    """Counters and gauges in Prometheus' text format."""
    feed: Feed = request.app.state.feed
    values = counters(service) | {"modallab_event_listeners": float(feed.listeners)}
    return "".join(f"# TYPE {name.partition('{')[0]} gauge\n{name} {value:g}\n" for name, value in values.items())
