"""The set-ups of an impact plan: where the sensors stand in each, and what joins them."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, SetUp
from modallab.core.rig import Rig


class SensorMove(NamedTuple):
    """One sensor to be moved: channel name, the point where it stands, the point where it belongs."""

    channel: str
    before: int | None
    after: int


def rig_in_set_up(rig: Rig, setup: SetUp) -> Rig:
    """The rig with its sensors where a set-up has them."""
    channels = [c.model_copy(update={"point": setup.points.get(c.name, c.point)}) for c in rig.channels]
    return Rig.model_validate(rig.model_copy(update={"channels": tuple(channels)}).model_dump())


def sensor_moves(before: Rig, after: Rig) -> tuple[SensorMove, ...]:
    """The sensors that stand elsewhere in `after`, the same rig in another set-up."""
    pairs = zip(before.channels, after.channels, strict=True)
    return tuple(
        SensorMove(new.name, old.point, new.point)
        for old, new in pairs
        if new.point is not None and new.point != old.point
    )


def split_setups(plan: ImpactPlan) -> tuple[ImpactPlan, ...]:
    """One plan a set-up, each with this one alone; the plan itself where it has none."""
    return tuple(plan.model_copy(update={"setups": (setup,)}) for setup in plan.setups) or (plan,)


def require_setups(plan: ImpactPlan, rig: Rig) -> None:
    """Reject set-ups that the rig cannot have, or that nothing joins.

    Raises:
        PlanError: one message with every problem.
    """
    problems = setup_problems(plan, rig)
    if problems:
        raise PlanError("; ".join(problems), where="impact plan", remedy="change setups in the plan, or the rig file")


def setup_problems(plan: ImpactPlan, rig: Rig) -> list[str]:
    """What is wrong with a plan's set-ups on a rig."""
    names = [setup.name for setup in plan.setups]
    problems = [f"setups: {name!r} occurs twice" for name in sorted({n for n in names if names.count(n) > 1})]
    own = [problem for setup in plan.setups for problem in _own_problems(setup, rig)]
    if own:
        return [*problems, *own]
    return [*problems, *_unjoined_setups(plan, [_points(rig_in_set_up(rig, setup)) for setup in plan.setups])]


def _own_problems(setup: SetUp, rig: Rig) -> list[str]:
    sensors, known = {c.name for c in rig.responses}, {p.id for p in rig.points}
    where = f"setups: {setup.name}"
    problems = [f"{where}: no sensor {n!r}; allowed: {sorted(sensors)}" for n in setup.points if n not in sensors]
    problems += [
        f"{where}: {name} at point {point}; allowed: {sorted(known)}"
        for name, point in setup.points.items()
        if point not in known
    ]
    if problems:
        return problems
    return _doubled_sensors(where, rig, setup)


def _doubled_sensors(where: str, rig: Rig, setup: SetUp) -> list[str]:
    """Two sensors at one point in one direction, unless the rig file has them so."""
    taken: dict[tuple[int, str], str] = {}
    problems: list[str] = []
    for channel in rig_in_set_up(rig, setup).responses:
        if channel.point is None:
            continue
        first = taken.setdefault((channel.point, channel.direction), channel.name)
        if first != channel.name and {first, channel.name} & set(setup.points):
            problems.append(f"{where}: {first} and {channel.name} both at point {channel.point}; allowed: one of them")
    return problems


def _points(rig: Rig) -> frozenset[int]:
    return frozenset(c.point for c in rig.responses if c.point is not None)


def _unjoined_setups(plan: ImpactPlan, standing: Sequence[frozenset[int]]) -> list[str]:
    """Neighbouring set-ups that share neither a sensor's point nor, by reciprocity, two struck points."""
    struck = frozenset(plan.points)
    return [
        f"setups: no common point joins {plan.setups[n].name} and {plan.setups[n + 1].name}; allowed: a sensor at "
        "the same point in both, or in each a sensor at a struck point"
        for n, (here, there) in enumerate(pairwise(standing))
        if not (here & there or (here & struck and there & struck))
    ]
