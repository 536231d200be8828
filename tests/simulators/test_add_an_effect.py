"""The two files of the how-to page are an effect: injected, among the candidates, listed, diagnosed, and gone again."""

from pathlib import Path

import pytest
from added_effect import NAME, added, page_files

from modallab.cli import main
from modallab.core.effects import Effect, catalogue
from modallab.core.errors import FormatError
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig
from modallab.gap.diagnosis import diagnose
from modallab.gap.model.candidates import beam_candidates
from modallab.twin.effects import model_of
from modallab_simulators.cantilever.blind_trials import draw_effect
from modallab_simulators.cantilever.effects import kinds
from modallab_simulators.cantilever.injected_effects import read_effect
from modallab_simulators.cantilever.trial import make_trial

RIVALS = (NAME, "ground_spring", "added_mass", "stiffness_loss", "clamp_rotation")
"""What could pass for it; that it stands among all candidates is seen without a fit."""

SPRING = Effect(effect=NAME, parameters={"k_slope": 5.0}, place={"x": 0.6})


@pytest.fixture(scope="module")
def link() -> Rig:
    path = Path(__file__).parents[2] / "src" / "modallab" / "cli" / "link_rig.yaml"
    return parse_rig(path.read_text(encoding="utf-8"), str(path))


def listed(capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["gap", "effects"]) == 0
    return capsys.readouterr().out


@pytest.mark.thorough("draws an effect of a stated gap")
def test_two_files_are_an_effect_for_as_long_as_they_are_there(
    tmp_path: Path, link: Rig, capsys: pytest.CaptureFixture[str]
):
    before = list(catalogue())
    with added(tmp_path, *page_files()):
        after = list(catalogue())
        assert after[after.index("ground_spring") + 1] == NAME
        assert NAME in listed(capsys)
        assert NAME in kinds()
        assert read_effect(f"{NAME},k_slope=5,x=0.6") == (SPRING, [])
        candidates = [c.effect for c in beam_candidates(link)]
        assert candidates[candidates.index("ground_spring") + 1] == NAME
        assert draw_effect(link, 3, NAME, 20.0).gap == pytest.approx(20.0, rel=0.1)
    assert list(catalogue()) == before
    assert NAME not in kinds()
    assert NAME not in listed(capsys)
    assert NAME not in [c.effect for c in beam_candidates(link)]
    with pytest.raises(FormatError, match=NAME):
        model_of(NAME)


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_diagnosis_finds_it_in_the_simulated_bench(tmp_path: Path, link: Rig):
    with added(tmp_path, *page_files()):
        campaign, truth = make_trial(link, 3, (SPRING,))
        found = diagnose(campaign, allowed=lambda name: name in RIVALS)
        assert truth["effects"] == [
            {"effect": NAME, "family": "structure", "parameters": {"k_slope": 5.0}, "place": {"x": 0.6}}
        ]
        assert [f.effect for f in found.effects] == [NAME]
        assert found.effects[0].parameters["k_slope"] == pytest.approx(5.0, rel=0.02)
        assert found.effects[0].place.x == pytest.approx(0.6, abs=0.005)
