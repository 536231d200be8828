"""What a page for operators asks that programs seldom do: whether a plan is possible, and the force of one block."""

from typing import Annotated

import numpy as np
from fastapi import Body

from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.core.documents.runs import BlockForce, PlanCheck
from modallab.core.errors import ConfigurationError, PlanError, RigError
from modallab.core.plan import Plan
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.rigs import state_of
from modallab.service.api.roles import role_needed
from modallab.service.api.router import make_router
from modallab.service.campaigns.begin import require_reasonable
from modallab.service.campaigns.queueing import duration_s
from modallab.service.campaigns.runs import block_record, record_of
from modallab.service.context import Service
from modallab.service.rigs.control import ControllerState
from modallab.storage.durable import planned_blocks

rigs = make_router("rigs")
blocks = make_router("blocks")


@rigs.post("/rigs/{rig}/plan-checks", responses=documented_responses(404), openapi_extra=role_needed("observer"))
def check_plan(rig: str, plan: Annotated[Plan, Body()], service: ServiceOf) -> PlanCheck:
    """Ask whether the rig could run a plan; nothing moves, and no lease is needed."""
    controller = state_of(service, rig)
    try:
        require_reasonable(plan, controller.rig)
        _require_possible(plan, controller)
    except (PlanError, RigError, ConfigurationError) as error:
        return PlanCheck(problems=(error.what,), blocks=0, duration_s=0.0)
    return PlanCheck(problems=(), blocks=planned_blocks(plan), duration_s=duration_s(plan))


def _require_possible(plan: Plan, controller: ControllerState) -> None:
    # A bench that is not open yet says nothing of itself; the run looks again.
    if controller.info is not None:
        require_possible(plan, controller.rig, controller.info)


@blocks.get("/runs/{run}/blocks/{n}/force", responses=documented_responses(404))
def get_force(run: str, n: int, service: ServiceOf) -> BlockForce:
    """The force of a block in N, and its amplitude spectrum: of a hit, what the hammer gave at each frequency."""
    return _force(service, run, n)


def _force(service: Service, run: str, n: int) -> BlockForce:
    # Imported here: it takes seconds, and the service can be asked everything else meanwhile.
    from modallab.signals.signals import to_signals

    record = record_of(service, run)
    block = service.store.block(run, block_record(service, run, n).note.name)
    signals = to_signals(block, record.rig)
    force = signals.force - np.median(signals.force)
    return BlockForce(
        run=run,
        n=n,
        rate_hz=signals.rate_hz,
        force_n=force,
        spectrum_hz=np.arange(force.size // 2 + 1) * signals.rate_hz / force.size,
        spectrum_n_s=np.abs(np.fft.rfft(force)) / signals.rate_hz,
    )
