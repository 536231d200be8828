"""What a plan can distinguish, before any data."""

import numpy as np
import pytest

from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.core.rig import Rig
from modallab.gap.design.distinguishability import advice_on_plan, distinguishability_of_plan
from modallab.gap.design.planned import records_of_plans


def test_hits_alone_cannot_see_the_shaker(rig: Rig) -> None:
    found = distinguishability_of_plan(rig, [ImpactPlan(points=(6, 10, 3))])
    assert "shaker_mass" not in found.effects
    assert np.allclose(np.diag(found.cosine), 1)
    assert np.all(np.abs(found.cosine) <= 1 + 1e-9)
    assert any("sine" in line for line in advice_on_plan(found, [ImpactPlan(points=(6, 10, 3))]))


def test_more_points_distinguish_more(rig: Rig) -> None:
    one, three = (distinguishability_of_plan(rig, [ImpactPlan(points=p)]) for p in ((10,), (6, 10, 3)))
    pair = [one.effects.index(n) for n in ("added_mass", "sensor_mass")]
    assert three.cosine[pair[0], pair[1]] <= one.cosine[pair[0], pair[1]] + 0.02


def test_a_plan_without_a_test_or_a_shaker_is_rejected(rig: Rig) -> None:
    with pytest.raises(PlanError):
        records_of_plans(rig, [])
    with pytest.raises(PlanError, match="shaker"):
        records_of_plans(rig.model_copy(update={"shaker_point": None}), [SinePlan()])


def test_a_mass_at_the_tip_and_the_sensors_look_alike_and_a_turned_sensor_is_no_row_of_its_own(rig: Rig) -> None:
    found = distinguishability_of_plan(rig, [ImpactPlan(points=(10,)), SinePlan()])
    assert "polarity" not in found.effects
    assert np.array_equal(found.cosine, found.cosine.T)
    assert found.cosine.min() >= 0
    assert found.cosine.max() <= 1
    pair = [found.effects.index(n) for n in ("added_mass", "sensor_mass")]
    assert found.cosine[pair[0], pair[1]] > 0.9


def test_a_gain_that_may_be_off_hides_a_plain_gain_error_and_a_calibrated_one_shows_it(rig: Rig) -> None:
    reported = Rig.model_validate({**rig.model_dump(exclude_unset=True), "tolerance": {"sensitivity": 0.02}})
    plans = [ImpactPlan(points=(6, 10, 3)), SinePlan()]
    assert "gain_error" in distinguishability_of_plan(reported, plans).hidden_effects()
    assert "gain_error" not in distinguishability_of_plan(rig, plans).hidden_effects()
    assert "added_mass" not in distinguishability_of_plan(reported, plans).hidden_effects()
