"""The reference page of plans holds every field, with its default."""

import re
from pathlib import Path

import pytest
from pydantic import BaseModel

from modallab.core.plan import BroadbandPlan, ForceControl, HitAcceptance, ImpactPlan, KnownMode, SinePlan

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "plan.md"


@pytest.mark.parametrize("model", [ImpactPlan, SinePlan, BroadbandPlan, HitAcceptance, ForceControl, KnownMode])
def test_every_field_of_a_plan_is_there(model: type[BaseModel]) -> None:
    said = set(re.findall(r"`(\w+)`", PAGE.read_text(encoding="utf-8")))
    assert set(model.model_fields) - {"kind"} <= said


@pytest.mark.parametrize(
    ("model", "heading"), [(ImpactPlan, "## Impact"), (SinePlan, "## Sine"), (BroadbandPlan, "## Broadband")]
)
def test_every_default_that_is_a_number_is_there(model: type[BaseModel], heading: str) -> None:
    text = PAGE.read_text(encoding="utf-8").split(heading)[1].split("\n## ")[0]
    for name, field in model.model_fields.items():
        if isinstance(field.default, int | float):
            row = next(line for line in text.splitlines() if line.startswith("| `") and f"`{name}`" in line)
            said = str(field.default).lower() if isinstance(field.default, bool) else f"{field.default:g}"
            assert said in row.split("|")[-2], name
