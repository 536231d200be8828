"""Blind trials: the truth is sealed first and opened last, and nothing is done twice."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from made_diagnosis import made_diagnosis

from modallab.blind.draw import NONE, PAIR, draw_trials
from modallab.blind.outcome import BlindOutcome, summarise_trials
from modallab.blind.page import render
from modallab.blind.request import BlindRequest
from modallab.blind.run import blind_folder, run_blind_trials
from modallab.blind.score import Trial
from modallab.blind.seal import hash_of, open_truth, publish_hashes, seal_truth
from modallab.blind.trial_answers import answer_trials, read_answers
from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.effects import Effect, catalogue
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign

MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})
TRUE_MASS = {"effect": "added_mass", "family": "structure", "parameters": {"mass": 0.05}, "place": {"x": 0.8}}
SOUND = BlindRequest(trials=0, none=1, seed=4, later=False)
NAMELESS = {"effect": "support_resonance", "family": "structure", "parameters": {}, "place": {"x": 0.0}}
"""No diagnosis looks for it yet: that it does not know is the right answer."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("blind")


@pytest.fixture(scope="module")
def found(folder: Path) -> BlindOutcome:
    """One sound bench, from the draw to the outcome."""
    return run_blind_trials(folder, SOUND)


def test_a_sound_bench_goes_all_the_way(found: BlindOutcome, folder: Path) -> None:
    figures = {figure.name: figure for figure in found.figures}
    assert figures["false alarms"].value == 0
    assert figures["false alarms"].count == 1
    assert json.loads((folder / "hashes.json").read_text(encoding="utf-8"))["hash"] == found.sealed
    assert hash_of((folder / "answers.jsonl").read_text(encoding="utf-8")) == found.answers


def test_what_was_done_is_not_done_again(found: BlindOutcome, folder: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}
    assert run_blind_trials(folder, SOUND) == found
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_other_trials_need_another_folder(found: BlindOutcome, folder: Path) -> None:
    with pytest.raises(DataError, match="other trials"):
        run_blind_trials(folder, SOUND.model_copy(update={"seed": 5}))


def test_a_campaign_says_nothing_of_its_truth(found: BlindOutcome, folder: Path) -> None:
    content = (folder / "campaigns" / "trial_0000.h5").read_bytes()
    assert b"link " not in content
    assert b"seed" not in content


def test_a_truth_that_was_changed_is_not_opened(tmp_path: Path) -> None:
    publish_hashes(tmp_path, {}, {"one": seal_truth(tmp_path, "one", {"effects": []})})
    assert open_truth(tmp_path, "one") == {"effects": []}
    seal_truth(tmp_path, "one", {"effects": [TRUE_MASS]})
    with pytest.raises(DataError, match="not the one that was sealed"):
        open_truth(tmp_path, "one")


def test_one_truth_has_another_hash_each_time_it_is_sealed(tmp_path: Path) -> None:
    assert seal_truth(tmp_path, "one", {"effects": []}) != seal_truth(tmp_path, "one", {"effects": []})


def test_trials_of_one_request_are_always_the_same_and_take_the_effects_in_turn() -> None:
    request = BlindRequest(trials=2 * len(catalogue()), none=3, pairs=2, seed=1)
    listed = draw_trials(request)
    assert listed == draw_trials(request)
    counts = [sum(draw.effect == name for draw in listed) for name in (*catalogue(), NONE, PAIR)]
    assert counts == [*(2 for _ in catalogue()), 3, 2]
    assert len({draw.seed for draw in listed}) == len(listed)
    assert not {draw.seed for draw in listed} & {d.seed for d in draw_trials(request.model_copy(update={"seed": 2}))}


def test_an_effect_that_no_bench_has_is_rejected() -> None:
    with pytest.raises(ValueError, match="no effect is called gremlin"):
        BlindRequest(effects=("gremlin",))
    with pytest.raises(ValueError, match="no trial"):
        BlindRequest(trials=0, none=0)


@pytest.fixture(scope="module")
def answers(make: Callable[..., Campaign], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Campaigns of somebody else, answered: `campaigns/one.h5` and `answers.jsonl`."""
    place = tmp_path_factory.mktemp("answers")
    (place / "campaigns").mkdir()
    write_campaign(make(tests=("sine",)), place / "campaigns" / "one.h5")
    said = blind_folder(place / "campaigns", None, place)
    assert said == hash_of((place / "answers.jsonl").read_text(encoding="utf-8"))
    return place


def test_an_answer_that_was_cut_off_is_given_anew(answers: Path, tmp_path: Path) -> None:
    out = tmp_path / "answers.jsonl"
    whole = (answers / "answers.jsonl").read_text(encoding="utf-8")
    out.write_text(whole + whole[:40], encoding="utf-8")
    assert [answer.name for answer in read_answers(out)] == ["one"]
    assert answer_trials({"one": answers / "campaigns" / "one.h5"}, out, None) == hash_of(whole)
    out.write_text("{}\n", encoding="utf-8")
    with pytest.raises(FormatError, match="line 1: is no answer"):
        read_answers(out)


def test_a_folder_is_answered_before_its_truths_are_read(answers: Path, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="no truth of one"):
        blind_folder(answers / "campaigns", tmp_path, answers)
    (tmp_path / "one.yaml").write_text(yaml.safe_dump({"effects": []}), encoding="utf-8")
    found = blind_folder(answers / "campaigns", tmp_path, answers)
    assert isinstance(found, BlindOutcome)
    assert found.answers == hash_of((answers / "answers.jsonl").read_text(encoding="utf-8"))
    assert [(e.effect, e.right) for e in found.effects] == [("none", 1)]
    with pytest.raises(DataError, match="holds no campaign"):
        blind_folder(tmp_path, None, answers)


def _trial(rig: Rig, name: str, truth: list[dict[str, Any]], *said: Effect, seen: float | None = None) -> Trial:
    diagnosis = made_diagnosis(rig, *said, verdict="known" if said else "unknown")
    return Trial(name, truth, diagnosis, 1.0, 2.0, seen_closed=seen, shut=None if seen is None else seen > 0.9)


def test_the_outcome_sums_up_effect_by_effect(rig: Rig) -> None:
    trials = [
        _trial(rig, "right", [TRUE_MASS], MASS, seen=0.989),
        _trial(rig, "missed", [TRUE_MASS]),
        _trial(rig, "strange", [NAMELESS]),
    ]
    found = summarise_trials(trials, "ab", "cd")
    by_name = {e.effect: e for e in found.effects}
    assert by_name["added_mass"].said == {"added_mass": 1, "unknown": 1}
    assert (by_name["added_mass"].right, by_name["support_resonance"].right) == (1, 1)
    figures = {figure.name: figure for figure in found.figures}
    assert figures["shrinkage predicted less measured, median"].value == pytest.approx(0.01)
    assert figures["gap closed in a later campaign"].value == 1.0
    assert figures["two effects named right"].value is None
    assert BlindOutcome.model_validate_json(found.model_dump_json()) == found
    page = render(found)
    for heading in ("Figures", "Effect by effect", "Diagnosis of each effect", "Reliability", "Shrinkage"):
        assert f"<h2>{heading}</h2>" in page


def test_at_the_terminal(found: BlindOutcome, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["gap", "blind", "--trials", "0", "--none", "1", "--seed", "4", "--no-later", "--out", str(folder)]
    assert main(asked) == 0
    assert "false alarms" in capsys.readouterr().out
    assert BlindOutcome.model_validate_json((folder / "blind.json").read_text(encoding="utf-8")) == found
    assert main([*asked, "--effects", "gremlin"]) != 0
    assert "no effect is called gremlin" in capsys.readouterr().err
