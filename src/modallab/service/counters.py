"""Numbers that say how the service does."""

import shutil

from sqlalchemy import func, select

from modallab.service.context import Service
from modallab.service.records.database import reading
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
