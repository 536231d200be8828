"""The experiment that separates what is left standing is chosen by what it would show, before it is made."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from unsure import of_sensors, remaining_explanations

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.effect import AlongBeam
from modallab.core.effects import Effect
from modallab.core.errors import DataError, PlanError
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.gap.design.experiments import DECIDES, Experiment, continue_campaign, next_experiments
from modallab.gap.design.information import probabilities_of_rivals
from modallab.gap.design.options import plans_of
from modallab.gap.design.planning import ExperimentPlanner
from modallab.gap.diagnosis import diagnose

MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})
STRUCK_OFF = Effect(effect="hit_position", parameters={"dx": 0.012}, place={"where": "hit"})
SENSOR_OFF = Effect(effect="position_error", parameters={"dx": 0.012}, place={"channel": 1})
SKEWED = Effect(effect="channel_skew", parameters={"seconds_per_channel": 2e-5}, place={"channel": "all"})
DELAYED = Effect(effect="trigger_delay", parameters={"seconds": 2e-5}, place={"channel": "all"})


@pytest.fixture(scope="module")
def struck_off(make: Callable[..., Campaign]) -> Campaign:
    """Hits at three points, each beside its mark, as one sensor at the first of these points sees them."""
    return of_sensors(make(STRUCK_OFF, tests=("impact",)), (6,))


@pytest.fixture(scope="module")
def at_its_point(struck_off: Campaign) -> Campaign:
    """The hits at the sensor alone: there it is the same whether the hits or the sensor are off."""
    return of_sensors(struck_off, (6,), hits=(6,))


@pytest.fixture(scope="module")
def found(at_its_point: Campaign) -> list[Experiment]:
    return next_experiments(at_its_point, remaining_explanations(at_its_point.rig, STRUCK_OFF, SENSOR_OFF))


def test_hits_elsewhere_tell_a_wrong_hit_from_a_wrong_sensor_and_hits_there_do_not(found: list[Experiment]) -> None:
    by_name = {e.name: e for e in found}
    assert by_name["hits again"].expected == pytest.approx(0.5, abs=0.02)
    assert by_name["hits again"].nats == pytest.approx(0.0, abs=0.1)
    assert found[0].expected > 0.99
    assert isinstance(found[0].plans[0], ImpactPlan)
    assert found[0].plans[0].points != (6,)


def test_of_experiments_that_tell_alike_the_shortest_comes_first(found: list[Experiment]) -> None:
    sure = [e for e in found if e.expected > 0.999]
    assert len(sure) > 2
    assert found[0].seconds == min(e.seconds for e in sure)


@pytest.mark.thorough("plans all experiments again")
def test_what_is_expected_is_what_the_records_then_say(struck_off: Campaign, at_its_point: Campaign) -> None:
    unsure = remaining_explanations(at_its_point.rig, STRUCK_OFF, SENSOR_OFF)
    planning = ExperimentPlanner.of(at_its_point, unsure)
    there = ExperimentPlanner.of(of_sensors(struck_off, (6,), hits=(6, 3)), unsure)
    off, sensor = (r.fit.cost for r in there.rivals.listed)
    planned = next(p for p in planning.ranked_by_slopes() if p.option.name == "hits at 3")
    # Two hits were made, and four of five that are planned are fitted.
    expected = planning.ranked_by_full_fits(planned).outlook.ratio[0, 1] / 2
    assert (sensor - off) / 2 == pytest.approx(expected, rel=0.5)
    assert expected > 100


def test_what_is_the_same_on_every_record_is_said_to_be(make: Callable[..., Campaign]) -> None:
    # Of one accelerometer in the first row, a skew for each row and a delay of all are the same.
    one = of_sensors(make(DELAYED, tests=("impact",)), (10,), hits=(6,))
    found = next_experiments(one, remaining_explanations(one.rig, DELAYED, SKEWED))
    assert max(e.expected for e in found) == pytest.approx(0.5, abs=0.02)
    assert found[0].expected < DECIDES


def test_two_places_of_a_mass_are_distinguished_by_hits_where_one_of_them_moves(make: Callable[..., Campaign]) -> None:
    # In much noise a sensor near the root feels neither mass well; the tip does.
    noise, rng = 0.09, np.random.default_rng(3)
    near, far = (MASS.model_copy(update={"parameters": {"mass": 2e-3}, "place": AlongBeam(x=x)}) for x in (0.8, 0.5))
    loud = make(near, tests=("impact",), spoil=lambda v, _: v + noise * rng.standard_normal(v.shape))
    converter = loud.rig.converter.model_copy(update={"noise_rms_v": noise}) if loud.rig.converter else None
    rig = loud.rig.model_copy(update={"converter": converter, "shaker_point": None})
    seen = of_sensors(replace(loud, rig=rig), (3,), hits=(3,))
    found = next_experiments(seen, remaining_explanations(seen.rig, near, far))
    single = {e.name: e for e in found if "," not in e.name}
    assert single["hits at 10"].nats > 1.3 * single["hits again"].nats > 0
    assert single["hits at 10"].expected == max(e.expected for e in single.values())


@pytest.mark.thorough("diagnoses a whole campaign")
def test_plans_agree_with_the_diagnosis_on_what_is_recorded(at_its_point: Campaign) -> None:
    said = diagnose(at_its_point)
    planning = ExperimentPlanner.of(at_its_point, said)
    costs = np.array([r.fit.cost for r in planning.rivals.listed])
    own = [r.probability for r in planning.rivals.listed]
    assert {r.effects for r in planning.rivals.listed} >= {("hit_position",), ("position_error",)}
    assert probabilities_of_rivals(planning.rivals, costs) == pytest.approx(own, abs=0.1)


def test_one_explanation_alone_leaves_nothing_to_separate(at_its_point: Campaign) -> None:
    with pytest.raises(PlanError, match="not leave two explanations"):
        next_experiments(at_its_point, remaining_explanations(at_its_point.rig, STRUCK_OFF))


def test_an_explanation_that_adds_to_a_likelier_one_is_no_rival_of_it(at_its_point: Campaign) -> None:
    found = remaining_explanations(at_its_point.rig, STRUCK_OFF)
    more = found.candidates[0].model_copy(update={"effects": ["hit_position", "added_mass"], "probability": 0.05})
    with pytest.raises(PlanError, match="not leave two explanations"):
        next_experiments(at_its_point, found.model_copy(update={"candidates": [*found.candidates, more]}))


def test_a_diagnosis_without_numbers_is_to_be_made_again(at_its_point: Campaign) -> None:
    found = remaining_explanations(at_its_point.rig, STRUCK_OFF, SENSOR_OFF)
    bare = [c.model_copy(update={"fitted": [], "twin": None}) for c in found.candidates]
    with pytest.raises(DataError, match="does not hold the numbers of hit_position"):
        next_experiments(at_its_point, found.model_copy(update={"candidates": bare}))


def test_what_depends_on_the_size_of_the_motion_is_not_planned(at_its_point: Campaign) -> None:
    drag = Effect(effect="air_drag", parameters={"c2_total": 1.0})
    with pytest.raises(PlanError, match="depends on the amplitude"):
        next_experiments(at_its_point, remaining_explanations(at_its_point.rig, STRUCK_OFF, drag))


def test_the_plan_of_a_campaign_is_read_off_its_records(make: Callable[..., Campaign]) -> None:
    impact, sine = plans_of(make(MASS))
    assert isinstance(impact, ImpactPlan)
    assert (impact.points, impact.hits, impact.rate_hz) == ((3, 6, 10), 2, 2000.0)
    assert isinstance(sine, SinePlan)
    assert sine.levels_v == pytest.approx({"low": 0.1, "high": 0.4}, rel=0.05)


def test_later_records_come_behind_under_names_of_their_own(at_its_point: Campaign) -> None:
    whole = continue_campaign(at_its_point, at_its_point)
    assert len({b.name for b in whole.blocks}) == 2 * len(at_its_point.blocks)
    assert [b.order for b in whole.blocks] == list(range(2 * len(at_its_point.blocks)))


@pytest.mark.thorough("plans all experiments again")
def test_what_nothing_on_the_rig_decides_is_not_run(
    make: Callable[..., Campaign], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = of_sensors(make(DELAYED, tests=("impact",)), (10,), hits=(6,))
    write_campaign(one, tmp_path / "c.h5")
    said = remaining_explanations(one.rig, SKEWED, DELAYED).model_dump_json()
    (tmp_path / "d.json").write_text(said, encoding="utf-8")
    asked = ["gap", "next", str(tmp_path / "c.h5"), "--diagnosis", str(tmp_path / "d.json")]
    assert main([*asked, "--run", "--bench", "sim://cantilever", "--data", str(tmp_path / "data")]) == 2
    assert "no experiment on this rig decides" in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "data").exists()


def test_at_the_terminal(at_its_point: Campaign, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_campaign(at_its_point, tmp_path / "c.h5")
    said = remaining_explanations(at_its_point.rig, STRUCK_OFF, SENSOR_OFF).model_dump_json()
    (tmp_path / "d.json").write_text(said, encoding="utf-8")
    assert main(["gap", "next", str(tmp_path / "c.h5"), "--diagnosis", str(tmp_path / "d.json")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "Strike 5 times at point" in out
    assert "the right explanation gets a probability of 0.99; 100 s at the bench." in out
