"""How a run begins: looked at as far as can be without the bench, then handed to the rig's controller."""

from pathlib import Path

from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.core.documents.runs import RunNew
from modallab.core.plan import Plan
from modallab.service.campaigns.plan_size import require_reasonable
from modallab.service.campaigns.remaining import remaining_plan
from modallab.service.context import Service
from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.rigs.control import ControllerState, StartRun
from modallab.service.rigs.transitions import rejection
from modallab.storage.durable import require_space
from modallab.storage.free_space import require_room
from modallab.storage.records import ENDED
from modallab.storage.samples import RESERVE_BYTES

LEAST_BYTES = 2


def begin(service: Service, campaign: str, new: RunNew, lease: str | None) -> str:
    """Begin a run; returns its name.

    Raises:
        NotFoundError: no such campaign, or no such run to continue.
        PlanError: the plan is not possible on this rig.
        DiskFullError: there is no room for what it would record.
        ModallabError: as `Control.start`.
    """
    entry = service.repository.campaign(campaign)
    controller = next((state for state in service.control.states() if state.id == entry.rig), None)
    if controller is None:
        raise NotFoundError(f"this service has no rig {entry.rig!r}", where=campaign, remedy="start it with that rig")
    service.leases.require(entry.rig, lease)
    plan = _plan(service, campaign, new)
    require_reasonable(plan, controller.rig)
    _require_possible(plan, controller)
    _require_room(service.folder, plan, len(controller.rig.channels))
    return service.control.start(StartRun(entry.rig, campaign, plan, lease, new.continues))


def _plan(service: Service, campaign: str, new: RunNew) -> Plan:
    if new.continues is None:
        if new.plan is None:
            raise ConflictError("a run needs a plan, or a run to continue", where="plan", remedy="send a plan")
        return new.plan
    before = service.repository.entry(new.continues)
    if before is None or before.campaign != campaign:
        raise NotFoundError(
            f"campaign {campaign} has no run {new.continues!r}", where="continues", remedy="look at its runs"
        )
    record = service.store.catalogue.run(new.continues)
    if record.state not in ENDED:
        raise rejection(record.state, "be continued")
    if not record.valid:
        raise ConflictError(
            "an aborted run is marked as invalid and not continued", where="continues", remedy="begin a new run"
        )
    return new.plan or remaining_plan(record.plan, service.store.catalogue.blocks(new.continues))


def _require_room(folder: Path, plan: Plan, channels: int) -> None:
    # The recorder looks again with what the device really delivers; counts are of two bytes at least.
    require_space(folder, 2 * RESERVE_BYTES)
    require_room(folder, plan, LEAST_BYTES * channels * round(plan.block_s * plan.rate_hz))


def _require_possible(plan: Plan, controller: ControllerState) -> None:
    # The controller says better what is wrong with a bench that is not open.
    if controller.info is not None:
        require_possible(plan, controller.rig, controller.info)
