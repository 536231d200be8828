"""What a plan can tell apart, before any data."""

import numpy as np
import pytest

from modallab.errors import PlanError
from modallab.gap.isolability import advice, isolability
from modallab.gap.planned import planned
from modallab.schema.plan import ImpactPlan, SinePlan
from modallab.schema.rig import Rig


def test_blows_alone_cannot_see_the_shaker(rig: Rig) -> None:
    found = isolability(rig, [ImpactPlan(points=(6, 10, 3))])
    assert "shaker_mass" not in found.effects
    assert np.allclose(np.diag(found.cosine), 1)
    assert np.all(np.abs(found.cosine) <= 1 + 1e-9)
    assert any("sine" in line for line in advice(found, [ImpactPlan(points=(6, 10, 3))]))


def test_more_points_tell_more_apart(rig: Rig) -> None:
    one, three = (isolability(rig, [ImpactPlan(points=p)]) for p in ((10,), (6, 10, 3)))
    pair = [one.effects.index(n) for n in ("added_mass", "sensor_mass")]
    assert three.cosine[pair[0], pair[1]] <= one.cosine[pair[0], pair[1]] + 0.02


def test_a_plan_without_a_test_or_a_shaker_is_refused(rig: Rig) -> None:
    with pytest.raises(PlanError):
        planned(rig, [])
    with pytest.raises(PlanError, match="shaker"):
        planned(rig.model_copy(update={"shaker_point": None}), [SinePlan()])
