"""What a test still has to record, and under which name; and one part of it once more."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from modallab.core.documents.runs import RepeatFrequency
from modallab.core.errors import PlanError
from modallab.core.plan import Plan, SinePlan


@dataclass(frozen=True, slots=True)
class HitTarget:
    """A hit that is requested.

    Attributes:
        point: point to hit.
        hit: its number at the point, from 1.
        repetition: how often it was kept before and then dropped.
    """

    point: int
    hit: int
    repetition: int = 0

    @property
    def name(self) -> str:
        """Name of its record."""
        return f"impact_p{self.point:02d}_{self.hit}" + (f"_again_{self.repetition}" if self.repetition else "")


@dataclass(frozen=True, slots=True)
class SineStep:
    """A burst that is requested.

    Attributes:
        level: name of the drive level.
        frequency_hz: to drive at.
        repetition: how often it was recorded before and is to be repeated.
        replaces: name of the record it takes the place of, once it is kept.
        downwards: whether it belongs to the second, downward sweep of two.
    """

    level: str
    frequency_hz: float
    repetition: int = 0
    replaces: str = ""
    downwards: bool = False

    @property
    def name(self) -> str:
        """Name of its record."""
        sweep = "_down" if self.downwards else ""
        return (
            sine_record_name(self.level, self.frequency_hz)
            + sweep
            + (f"_again_{self.repetition}" if self.repetition else "")
        )


def steps_of_plan(plan: SinePlan) -> list[SineStep]:
    """The bursts of a plan, in order: level by level, in each the sweep that is asked for."""
    given, up = list(plan.frequencies_hz), sorted(plan.frequencies_hz)
    order = {"given": given, "up": up, "down": up[::-1], "up-down": up}[plan.sweep]
    steps: list[SineStep] = []
    for level in plan.levels_v:
        steps += [SineStep(level, f) for f in order]
        if plan.sweep == "up-down":
            steps += [SineStep(level, f, downwards=True) for f in up[::-1]]
    return steps


def repeated_steps(request: RepeatFrequency, kept: Mapping[str, SineStep]) -> list[SineStep]:
    """The steps a request asks for, out of those that were kept."""
    return [
        replace(step, repetition=step.repetition + 1, replaces=name)
        for name, step in kept.items()
        if round(step.frequency_hz, 3) == round(request.frequency_hz, 3) and request.level in (None, "", step.level)
    ]


def sine_record_name(level: str, frequency_hz: float) -> str:
    """Name of a sine record."""
    return f"sine_{level}_{frequency_hz:07.3f}"


def require_step(plan: Plan, frequency_hz: float, level: str = "") -> SinePlan:
    """Reject what a plan does not hold.

    Args:
        plan: of the run.
        frequency_hz: one of the plan's.
        level: one of the plan's; empty: any.

    Raises:
        PlanError: the plan is of no sine test, or does not hold this frequency or level.
    """
    if not isinstance(plan, SinePlan):
        raise PlanError(
            f"an {plan.kind} test has no frequencies to repeat",
            remedy="drop a hit instead; it is then requested again",
        )
    if not any(_is_same_frequency(f, frequency_hz) for f in plan.frequencies_hz):
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
    """Reject to repeat what has not been recorded yet.

    Args:
        plan: of the run.
        frequency_hz: one of the plan's.
        level: one of the plan's; empty: any.
        blocks: names of the blocks that count.

    Raises:
        PlanError: it is still to come.
    """
    names = [sine_record_name(name, frequency_hz) for name in plan.levels_v if level in ("", name)]
    if not any(block == name or block.startswith(f"{name}_") for block in blocks for name in names):
        raise PlanError(f"{frequency_hz:g} Hz has not been recorded yet", remedy="wait until it is recorded")


def _is_same_frequency(one_hz: float, other_hz: float) -> bool:
    return round(one_hz, 3) == round(other_hz, 3)
