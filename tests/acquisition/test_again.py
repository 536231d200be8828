"""Repeating one frequency of a run: what is rejected."""

import pytest

from modallab.acquisition.procedures.target import require_recorded, require_step
from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, SinePlan

PLAN = SinePlan(frequencies_hz=(27.34375, 60.0), levels_v={"low": 0.5, "high": 2.0}, settle_s=3.0)


def test_what_the_plan_holds_may_be_repeated() -> None:
    assert require_step(PLAN, 27.344, "high") == PLAN
    assert require_step(PLAN, 60.0) == PLAN


@pytest.mark.parametrize(
    ("plan", "frequency", "level", "said"),
    [
        (PLAN, 61.0, "", "61 Hz is none"),
        (PLAN, float("nan"), "", "nan Hz is none"),
        (PLAN, 60.0, "middle", "no level 'middle'"),
        (ImpactPlan(points=(1,)), 60.0, "", "an impact test has no frequencies"),
    ],
)
def test_what_the_plan_does_not_hold_is_rejected(
    plan: SinePlan | ImpactPlan, frequency: float, level: str, said: str
) -> None:
    with pytest.raises(PlanError, match=said) as caught:
        require_step(plan, frequency, level)
    assert caught.value.remedy


def test_what_is_still_to_come_cannot_be_repeated_and_a_repeat_can() -> None:
    with pytest.raises(PlanError, match="has not been recorded yet"):
        require_recorded(PLAN, 60.0, "", ["sine_low_027.344"])
    with pytest.raises(PlanError, match="has not been recorded yet"):
        require_recorded(PLAN, 60.0, "high", ["sine_low_060.000"])
    require_recorded(PLAN, 60.0, "", ["sine_low_060.000_again_2"])
