"""What is left of a plan after a run that ended early."""

from collections.abc import Sequence

from modallab.core.plan import ImpactPlan, Plan
from modallab.service.errors import ConflictError
from modallab.storage.records import BlockRecord


def remaining_plan(plan: Plan, blocks: Sequence[BlockRecord]) -> Plan:
    """The same plan without what good blocks are there for.

    A point of an impact test is struck anew if any of its hits is missing, since a plan wants as many at each point.
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
    have = {(note.level, note.frequency_hz) for note in good}
    missing = [(level, f) for level in plan.levels_v for f in plan.frequencies_hz if (level, f) not in have]
    if not missing:
        raise _complete()
    levels = {level: volts for level, volts in plan.levels_v.items() if any(level == other for other, _ in missing)}
    frequencies = tuple(f for f in plan.frequencies_hz if any(f == g for _, g in missing))
    return plan.model_copy(update={"frequencies_hz": frequencies, "levels_v": levels})


def _complete() -> ConflictError:
    return ConflictError("the run has all its plan asked for", where="continues", remedy="send a plan of its own")
