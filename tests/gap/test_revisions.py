"""A diagnosis put into the simulation shuts the gap, and the rig file remembers how."""

from collections.abc import Callable
from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest
from made_diagnosis import made_diagnosis

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.errors import DataError, RigError
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.rig.rig_file import dump_rig, parse_rig, read_rig, write_rig
from modallab.gap.report.calibrated import diagnosed_twin, twin_of_rig_file
from modallab.gap.report.effect_inspection import is_in_revisions
from modallab.gap.revisions import revision_history, rig_at_revision, with_diagnosis
from modallab.reporting.revisions_report import revisions_section
from modallab.twin.modes import solve_modes
from modallab_simulators.cantilever import open_bench

Make = Callable[..., Campaign]
MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})
HALF = Effect(effect="gain_error", parameters={"gain": 0.5}, place={"channel": 5})
HUM = Effect(effect="mains_hum", parameters={"volts": 0.01, "hz": 50.0}, place={"channel": "all"})
DAY = date(2026, 5, 4)


@pytest.fixture(scope="module")
def revised(rig: Rig) -> Rig:
    first = with_diagnosis(rig, made_diagnosis(rig, MASS), DAY, "first")
    return with_diagnosis(first, made_diagnosis(rig, HALF), DAY, "second")


def test_every_revision_is_closer_to_the_bench_than_the_one_before(make: Make, revised: Rig) -> None:
    campaign = make(MASS, HALF, tests=("impact",))
    steps = revision_history(revised, [replace(campaign, rig=revised, source="again")])
    gaps = [step.measured["again"] for step in steps]
    assert gaps[0] > gaps[1] > 5 * gaps[2]
    assert gaps[2] == pytest.approx(1.0, abs=0.1)
    assert [step.effects for step in steps] == ["as first believed", "added mass", "gain error"]


def test_a_rig_file_with_revisions_reads_as_it_was_written(revised: Rig) -> None:
    assert parse_rig(dump_rig(revised), "revised") == revised
    assert revised.known_effects == (MASS, HALF)


def test_a_rig_file_without_revisions_says_nothing_of_them(rig: Rig) -> None:
    assert "revisions" not in dump_rig(rig)


def test_the_twin_carries_what_the_revisions_know(rig: Rig, revised: Rig) -> None:
    twin = twin_of_rig_file(revised)
    assert (0.8, 0.05) in twin.structure.masses
    assert twin.chain.gain[5] == 0.5
    after = diagnosed_twin(made_diagnosis(revised, verdict="no_gap"), revised)
    both = diagnosed_twin(made_diagnosis(rig, MASS, HALF), rig)
    assert np.allclose(solve_modes(after.structure).poles, solve_modes(both.structure).poles)
    assert after.chain.gain == both.chain.gain


def test_the_simulated_bench_carries_it_unless_its_address_says_what_is_wrong(revised: Rig) -> None:
    effects = [
        bench.info.facts["effects"]
        for bench in (
            open_bench(f"sim://cantilever?seed=1{more}", revised)
            for more in ("", "&effect=none", "&effect=added_mass,mass=0.05,x=0.8")
        )
    ]
    assert "gain_error" in effects[0]
    assert effects[1] == "[]"
    assert "added_mass" in effects[2]
    assert "gain_error" not in effects[2]


def test_what_no_force_predicts_is_known_if_it_is_of_about_the_size_it_was(rig: Rig) -> None:
    revised = with_diagnosis(rig, made_diagnosis(rig, HUM), DAY)
    (found,) = made_diagnosis(rig, HUM).effects
    assert is_in_revisions(found, revised)
    assert not is_in_revisions(found.model_copy(update={"parameters": {"volts": 0.03, "hz": 50.0}}), revised)
    assert not is_in_revisions(found, rig)


def test_what_cannot_be_applied_says_why(rig: Rig, revised: Rig) -> None:
    with pytest.raises(DataError, match="no gap"):
        with_diagnosis(rig, made_diagnosis(rig, verdict="no_gap"), DAY)
    with pytest.raises(DataError, match="no known effect"):
        with_diagnosis(rig, made_diagnosis(rig, verdict="unknown"), DAY)
    with pytest.raises(RigError, match="is already in the rig"):
        with_diagnosis(revised, made_diagnosis(rig, MASS), DAY)
    with pytest.raises(RigError, match="of 'another'"):
        with_diagnosis(rig, made_diagnosis(rig.model_copy(update={"name": "another"}), MASS), DAY)


def test_the_first_revisions_are_a_rig_of_their_own(rig: Rig, revised: Rig) -> None:
    assert rig_at_revision(revised, 0) == rig
    assert rig_at_revision(revised, 1).known_effects == (MASS,)


def test_the_curve_has_a_point_for_each_revision_and_way_of_measuring(revised: Rig) -> None:
    steps = [step.model_copy(update={"measured": {"again": 3.0}}) for step in revision_history(revised)]
    assert str(revisions_section(steps)).count("<circle") == 6


def test_at_the_terminal(rig: Rig, make: Make, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_rig(rig, tmp_path / "rig.yaml")
    (tmp_path / "d.json").write_text(made_diagnosis(rig, MASS).model_dump_json(), encoding="utf-8")
    second = tmp_path / "rig2.yaml"
    assert (
        main(["gap", "apply", str(tmp_path / "d.json"), "--rig", str(tmp_path / "rig.yaml"), "--out", str(second)]) == 0
    )
    assert read_rig(second).known_effects == (MASS,)
    write_campaign(make(MASS, tests=("impact",)), tmp_path / "c.h5")
    page = tmp_path / "history.html"
    assert main(["gap", "history", str(second), "--on", str(tmp_path / "c.h5"), "--report", str(page)]) == 0
    assert "revision 1, with added mass" in capsys.readouterr().out
    assert "Progress of the simulation" in page.read_text(encoding="utf-8")
