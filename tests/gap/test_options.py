"""What could be done next is something that the rig can run itself, within its limits."""

from collections.abc import Callable

import numpy as np
import pytest
from unsure import of_sensors, remaining_explanations, rig_of_sensors

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.core.rig import Limits, Rig
from modallab.gap.design.options import MOST_OF_LIMIT, limit_force, possible_experiments, sines_on_all_lines
from modallab.gap.design.planning import ExperimentPlanner

LIMITS = Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=4.0, acceleration_m_s2=2.0, max_burst_s=60.0)
HITS = ImpactPlan(points=(6,), hits=2, rate_hz=4000.0)
SINES = SinePlan(frequencies_hz=(5.859, 31.25), levels_v={"low": 2.0}, rate_hz=2000.0)
STRUCK_OFF = Effect(effect="hit_position", parameters={"dx": 0.012}, place={"where": "hit"})
SENSOR_OFF = Effect(effect="position_error", parameters={"dx": 0.012}, place={"channel": 1})


@pytest.fixture(scope="module")
def limited(rig: Rig) -> Rig:
    return rig.model_copy(update={"limits": LIMITS})


def test_new_hits_are_recorded_as_those_before_and_nearest_to_the_tip_first(limited: Rig) -> None:
    found = possible_experiments(limited, [HITS], [])
    hits = [plan for o in found for plan in o.plans if isinstance(plan, ImpactPlan)]
    assert [plan.points for plan in hits[:3]] == [(10,), (9,), (8,)]
    assert {plan.rate_hz for plan in hits} == {4000.0}
    assert found[0].duration_s == 100.0


def test_few_sensors_are_not_asked_where_a_hit_landed(limited: Rig) -> None:
    for points, checked in (((6,), False), ((3, 6, 10), True)):
        first = possible_experiments(rig_of_sensors(limited, points), [HITS], [])[0].plans[0]
        assert isinstance(first, ImpactPlan)
        assert first.acceptance.check_point is checked


def test_a_louder_level_keeps_below_the_force_that_the_rig_allows(limited: Rig) -> None:
    louder = next(o for o in possible_experiments(limited, [SINES], []) if o.name == "third level").plans[0]
    assert isinstance(louder, SinePlan)
    assert louder.force is not None
    assert louder.force.levels_n == {"louder": pytest.approx(MOST_OF_LIMIT * 4.0)}
    assert louder.rate_hz == 2000.0
    assert limit_force(louder, 1.2).force != louder.force
    assert limit_force(louder, 100.0) is louder


def test_only_lines_are_offered_that_were_not_driven(limited: Rig) -> None:
    lines = np.array(sines_on_all_lines(limited, [SINES]).frequencies_hz) * SINES.block_s
    assert lines == pytest.approx(np.round(lines), abs=1e-3)
    assert not {6, 32} & set(np.round(lines).astype(int).tolist())


def test_without_a_shaker_only_hits_are_offered(limited: Rig) -> None:
    bare = limited.model_copy(update={"shaker_point": None})
    assert all(isinstance(plan, ImpactPlan) for o in possible_experiments(bare, [HITS], []) for plan in o.plans)


def test_sines_move_no_sensor_beyond_the_limit_of_acceleration(make: Callable[..., Campaign], limited: Rig) -> None:
    seen = of_sensors(make(STRUCK_OFF, tests=("impact",)), (6,), hits=(6,))
    rig = rig_of_sensors(limited, (6,))
    planning = ExperimentPlanner.of(Campaign(rig, seen.blocks), remaining_explanations(rig, STRUCK_OFF, SENSOR_OFF))
    sines = next(p for p in planning.ranked_by_slopes() if p.option.name == "sines")
    data = sines.layout.predicted_by(planning.rivals.listed[0].fit.problem.twin(planning.rivals.listed[0].fit.u)).sines
    assert data is not None
    largest = np.max(np.abs(data.rows.y.reshape(1, *data.source.lines.shape)) * np.abs(data.source.force)[:, None])
    assert 0.1 * LIMITS.acceleration_m_s2 < largest <= 1.001 * MOST_OF_LIMIT * LIMITS.acceleration_m_s2
