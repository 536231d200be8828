"""How a run begins: looked at as far as can be without the bench, then handed to the rig's controller."""

import hashlib
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.core.documents.runs import RunRequest
from modallab.core.errors import PlanError
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan
from modallab.core.rig import Rig
from modallab.service.context import Service
from modallab.service.errors import ConflictError, NotFoundError
from modallab.service.records.archive import ArchivedRecords
from modallab.service.records.repository import RunKey
from modallab.service.rigs.control import ControllerState, StartRun, transition_error
from modallab.storage.durable import planned_blocks, require_room, require_space
from modallab.storage.records import ENDED, BlockNote, BlockRecord
from modallab.storage.samples import RESERVE_BYTES

LEAST_BYTES = 2
MAX_BLOCK_BYTES = 256 << 20
MAX_RATE_HZ = 1e6
MAX_SECONDS = 3600.0
MAX_BLOCKS = 100_000
_BYTES_A_SAMPLE = 8


def begin_run(service: Service, campaign: str, new: RunRequest, lease: str | None, key: str | None = None) -> str:
    """Begin a run; returns its name. Under one key it is begun once: asked again, it is the name of that run.

    Raises:
        IdempotencyError: another request was sent with the key.
        NotFoundError: no such campaign, or no such run to continue.
        PlanError: the plan is not possible on this rig.
        DiskFullError: there is no room for what it would record.
        ModallabError: as `Control.start`.
    """
    asked = None if key is None else RunKey(key, _digest_of_request(campaign, new))
    begun = None if asked is None else service.repository.run_of(asked)
    if begun is not None:
        return begun
    entry = service.repository.campaign(campaign)
    controller = next((state for state in service.control.states() if state.id == entry.rig), None)
    if controller is None:
        raise NotFoundError(f"this service has no rig {entry.rig!r}", where=campaign, remedy="start it with that rig")
    service.leases.require(entry.rig, lease)
    ArchivedRecords(service.engine).require_present(campaign)
    plan = _complete_plan(service, campaign, new)
    require_plan(plan, controller)
    _require_room(service.folder, plan, len(controller.rig.channels))
    return service.control.start(StartRun(entry.rig, campaign, plan, lease, new.continues, asked))


def _digest_of_request(campaign: str, new: RunRequest) -> str:
    return hashlib.sha256(f"{campaign} {new.model_dump_json()}".encode()).hexdigest()


def _complete_plan(service: Service, campaign: str, new: RunRequest) -> Plan:
    if new.continues is None:
        if new.plan is None:
            raise ConflictError("a run needs a plan, or a run to continue", where="plan", remedy="send a plan")
        return new.plan
    before = service.repository.run_entry(new.continues)
    if before is None or before.campaign != campaign:
        raise NotFoundError(
            f"campaign {campaign} has no run {new.continues!r}", where="continues", remedy="read the list of its runs"
        )
    aside = ArchivedRecords(service.engine).state_of_run(new.continues, "")
    if aside is not None and aside.state != "archived":
        raise ConflictError("a deleted run cannot be continued", where="continues", remedy="restore it first")
    record = service.store.catalogue.run(new.continues)
    if record.state not in ENDED:
        raise transition_error(record.state, "be continued")
    if not record.valid:
        raise ConflictError(
            "an aborted run is invalid and cannot be continued", where="continues", remedy="start a new run"
        )
    return new.plan or remaining_plan(record.plan, service.store.catalogue.blocks(new.continues))


def _require_room(folder: Path, plan: Plan, channels: int) -> None:
    # The recorder looks again with what the device really delivers; counts are of two bytes at least.
    require_space(folder, 2 * RESERVE_BYTES)
    require_room(folder, plan, LEAST_BYTES * channels * round(plan.block_s * plan.rate_hz))


def require_plan(plan: Plan, controller: ControllerState) -> None:
    """Reject a plan that this rig cannot do, as far as can be seen without the bench.

    Raises:
        PlanError: what is wrong with it.
    """
    require_sensible_numbers(plan, controller.rig)
    # The controller says better what is wrong with a bench that is not open.
    if controller.info is not None:
        require_possible(plan, controller.rig, controller.info)


def remaining_plan(plan: Plan, blocks: Sequence[BlockRecord]) -> Plan:
    """The same plan without what good blocks are there for.

    A point of an impact test is struck again if any of its hits is missing, since a plan wants as many at each point.
    Levels of a sine test keep all frequencies that are missing at any of them.

    Raises:
        ConflictError: nothing is left to do.
    """
    good = [block.note for block in blocks if block.note.accepted]
    if isinstance(plan, ImpactPlan):
        counts = {point: sum(note.drive_point == point for note in good) for point in plan.points}
        points = tuple(point for point in plan.points if counts[point] < plan.hits)
        if not points:
            raise _complete()
        return plan.model_copy(update={"points": points})
    if isinstance(plan, BroadbandPlan):
        return _remaining_levels(plan, good)
    have = {(note.level, note.frequency_hz) for note in good}
    missing = [(level, f) for level in plan.levels_v for f in plan.frequencies_hz if (level, f) not in have]
    if not missing:
        raise _complete()
    levels = {level: volts for level, volts in plan.levels_v.items() if any(level == other for other, _ in missing)}
    frequencies = tuple(f for f in plan.frequencies_hz if any(f == g for _, g in missing))
    return plan.model_copy(update={"frequencies_hz": frequencies, "levels_v": levels})


def _remaining_levels(plan: BroadbandPlan, good: Sequence[BlockNote]) -> BroadbandPlan:
    # A level is taken again whole: its blocks are averaged, and belong to one time.
    counts = {level: sum(note.level == level for note in good) for level in plan.levels_v}
    levels = {level: volts for level, volts in plan.levels_v.items() if counts[level] < plan.blocks}
    if not levels:
        raise _complete()
    return plan.model_copy(update={"levels_v": levels})


def _complete() -> ConflictError:
    return ConflictError("the run has completed its plan", where="continues", remedy="send a plan with the request")


def require_sensible_numbers(plan: Plan, rig: Rig) -> None:
    """Reject numbers that are not finite, or beyond all that a bench could be asked for.

    Raises:
        PlanError: names every such field.
    """
    numbers = {name: value for name, value in plan.model_dump().items() if isinstance(value, float)}
    problems = [f"{name} is {value}; allowed: finite numbers" for name, value in numbers.items() if not isfinite(value)]
    problems += [
        f"{name} is {value:g}; allowed: up to {MAX_SECONDS:g}"
        for name, value in numbers.items()
        if name.endswith("_s") and value > MAX_SECONDS
    ]
    problems += [
        f"{name} is {value:g}; allowed: up to {MAX_RATE_HZ:g}"
        for name, value in numbers.items()
        if name in ("rate_hz", "delivered_hz") and value > MAX_RATE_HZ
    ]
    if not problems:
        problems = _too_many(plan, rig)
    if problems:
        raise PlanError("; ".join(problems), where=f"{plan.kind} plan", remedy="change the plan")


def _too_many(plan: Plan, rig: Rig) -> list[str]:
    samples = plan.block_s * plan.rate_hz
    found: list[str] = []
    if samples < 16 or samples * len(rig.channels) * _BYTES_A_SAMPLE > MAX_BLOCK_BYTES:
        found.append(f"a block of block_s at rate_hz has {samples:g} samples a channel; allowed: 16 to as many as fit")
    blocks = planned_blocks(plan)
    if blocks > MAX_BLOCKS:
        found.append(f"{blocks} blocks; allowed: up to {MAX_BLOCKS}")
    return found
