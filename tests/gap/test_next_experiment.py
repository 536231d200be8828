"""The experiment that separates what is left standing is chosen by what it would show, before it is made."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from made_diagnosis import made_diagnosis

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.diagnosis import CandidateSet, Diagnosis
from modallab.core.effects import Effect
from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.gap.design.experiments import continued, next_experiments, plans_of

MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})


def left_standing(rig: Rig, *names: str) -> Diagnosis:
    share = 1 / len(names)
    sets = [CandidateSet(effects=[name], probability=share - 0.01 * k, gap=1.0) for k, name in enumerate(names)]
    return made_diagnosis(rig, MASS).model_copy(update={"candidates": sets})


@pytest.fixture(scope="module")
def sines(make: Callable[..., Campaign]) -> Campaign:
    return make(MASS, tests=("sine",))


def test_what_only_hits_can_show_asks_for_hits(rig: Rig, sines: Campaign) -> None:
    best = next_experiments(sines, left_standing(rig, "hit_position", "position_error"))[0]
    assert best.before == 0.0
    assert best.after > 100
    assert isinstance(best.plans[0], ImpactPlan)


def test_every_experiment_adds_to_what_is_known_and_the_best_is_first(rig: Rig, sines: Campaign) -> None:
    found = next_experiments(sines, left_standing(rig, "added_mass", "sensor_mass"))
    assert all(e.after >= 0.999 * e.before > 0 for e in found)
    assert found[0].after == pytest.approx(max(e.after for e in found), rel=0.1)
    assert {"third level", "sines about modes"} - {e.name for e in found} <= {"sines about modes"}
    assert "hits at 10" in {e.name for e in found}


def test_one_explanation_alone_leaves_nothing_to_separate(rig: Rig, sines: Campaign) -> None:
    with pytest.raises(PlanError, match="no two explanations"):
        next_experiments(sines, left_standing(rig, "added_mass"))


def test_the_plan_of_a_campaign_is_read_off_its_records(make: Callable[..., Campaign]) -> None:
    impact, sine = plans_of(make(MASS))
    assert isinstance(impact, ImpactPlan)
    assert (impact.points, impact.hits, impact.rate_hz) == ((3, 6, 10), 2, 2000.0)
    assert isinstance(sine, SinePlan)
    assert sine.levels_v == pytest.approx({"low": 0.1, "high": 0.4}, rel=0.05)


def test_later_records_come_behind_under_names_of_their_own(sines: Campaign) -> None:
    whole = continued(sines, sines)
    assert len({b.name for b in whole.blocks}) == 2 * len(sines.blocks)
    assert [b.order for b in whole.blocks] == list(range(2 * len(sines.blocks)))


def test_what_nothing_on_the_rig_decides_is_not_run(
    sines: Campaign, rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Of one accelerometer in the first row, a skew for each row and a delay of all are the same.
    blocks = [replace(b, samples=b.samples[:2], scale=b.scale[:2], units=b.units[:2]) for b in sines.blocks]
    few = rig.model_copy(update={"channels": rig.channels[:2]})
    one = replace(sines, rig=few, blocks=tuple(replace(b, channels=b.channels[:2]) for b in blocks))
    write_campaign(one, tmp_path / "c.h5")
    said = left_standing(rig, "channel_skew", "trigger_delay").model_dump_json()
    (tmp_path / "d.json").write_text(said, encoding="utf-8")
    asked = ["gap", "next", str(tmp_path / "c.h5"), "--diagnosis", str(tmp_path / "d.json")]
    assert main([*asked, "--run", "--bench", "sim://cantilever", "--data", str(tmp_path / "data")]) == 2
    assert "no experiment on this rig decides" in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "data").exists()


def test_at_the_terminal(rig: Rig, sines: Campaign, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_campaign(sines, tmp_path / "c.h5")
    said = left_standing(rig, "hit_position", "position_error").model_dump_json()
    (tmp_path / "d.json").write_text(said, encoding="utf-8")
    assert main(["gap", "next", str(tmp_path / "c.h5"), "--diagnosis", str(tmp_path / "d.json")]) == 0
    assert "Strike 5 times at point" in capsys.readouterr().out
