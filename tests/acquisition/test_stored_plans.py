"""Plans that were stored under the field names of an earlier version."""

import pytest
from pydantic import TypeAdapter, ValidationError

from modallab.core.plan import ImpactPlan, Plan, SinePlan

PLAN: TypeAdapter[Plan] = TypeAdapter(Plan)

RENAMED = {"max_rejections": "max_refusals", "wait_s": "rest_s", "settle_timeout_s": "rest_timeout_s"}
"""Field of today -> its name in an earlier version."""


def test_fields_of_an_earlier_version_are_read_under_their_names_of_today() -> None:
    impact = PLAN.validate_python({"kind": "impact", "points": [3], RENAMED["max_rejections"]: 7})
    assert isinstance(impact, ImpactPlan)
    assert impact.max_rejections == 7
    sine = PLAN.validate_python({"kind": "sine", RENAMED["wait_s"]: 3.0, RENAMED["settle_timeout_s"]: 40.0})
    assert isinstance(sine, SinePlan)
    assert (sine.wait_s, sine.settle_timeout_s) == (3.0, 40.0)


def test_the_old_and_the_new_name_at_once_are_an_error() -> None:
    old = RENAMED["max_rejections"]
    with pytest.raises(ValidationError, match=old):
        PLAN.validate_python({"kind": "impact", "points": [3], old: 7, "max_rejections": 8})
