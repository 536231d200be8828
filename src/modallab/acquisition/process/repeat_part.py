"""One part of a sine test once more, as a run of its own, when the run it was in has ended."""

from collections.abc import Collection

from modallab.acquisition.procedures.target import block_name
from modallab.core.errors import PlanError
from modallab.core.plan import Plan, SinePlan


def repeat_plan(plan: Plan, frequency_hz: float, level: str = "") -> SinePlan:
    """The plan that repeats one frequency of a recorded sine run, with everything else as it was.

    Run it, then drop the block it replaces: `Store.drop(run, block_name(level, frequency_hz))`. A campaign of both runs
    then holds the frequency once.

    Args:
        plan: of the recorded run.
        frequency_hz: one of the plan's.
        level: one of the plan's; empty: all.

    Raises:
        PlanError: the plan is of no sine test, or does not hold this frequency or level.
    """
    sine = require_step(plan, frequency_hz, level)
    found = tuple(f for f in sine.frequencies_hz if _same(f, frequency_hz))
    levels = {name: volts for name, volts in sine.levels_v.items() if level in ("", name)}
    return sine.model_copy(update={"frequencies_hz": found, "levels_v": levels})


def require_step(plan: Plan, frequency_hz: float, level: str = "") -> SinePlan:
    """Reject what a plan does not hold.

    Raises:
        PlanError: see `repeat_plan`.
    """
    if not isinstance(plan, SinePlan):
        raise PlanError(
            f"an {plan.kind} test has no frequencies to repeat",
            remedy="drop a hit instead; it is then asked for again",
        )
    if not any(_same(f, frequency_hz) for f in plan.frequencies_hz):
        raise PlanError(
            f"{frequency_hz:g} Hz is none of the plan's frequencies",
            where="frequencies_hz",
            remedy=f"name one of: {', '.join(f'{f:.3f}' for f in plan.frequencies_hz)}",
        )
    if level and level not in plan.levels_v:
        raise PlanError(
            f"the plan has no level {level!r}", where="levels_v", remedy=f"name one of: {', '.join(plan.levels_v)}"
        )
    return plan


def require_recorded(plan: SinePlan, frequency_hz: float, level: str, blocks: Collection[str]) -> None:
    """Reject a repetition of what has not been recorded yet.

    Args:
        plan: of the run.
        frequency_hz: one of the plan's.
        level: one of the plan's; empty: any.
        blocks: names of the blocks that count.

    Raises:
        PlanError: it is still to come.
    """
    names = [block_name(name, frequency_hz) for name in plan.levels_v if level in ("", name)]
    if not any(block == name or block.startswith(f"{name}_") for block in blocks for name in names):
        raise PlanError(f"{frequency_hz:g} Hz has not been recorded yet", remedy="wait: it is still to come")


def _same(one_hz: float, other_hz: float) -> bool:
    return round(one_hz, 3) == round(other_hz, 3)
