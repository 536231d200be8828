"""An estimator is one file: with it, everything knows it; without it, nothing does."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from added_file import added, write_example
from pages import ROOT

from modallab.cli import main
from modallab.core.errors import ConfigurationError, IdentificationError, JobError, ModallabError
from modallab.formats import read_campaign, read_rig
from modallab.identification import IdentificationOptions, estimator_names, estimators, find_estimator
from modallab.pipelines.curves import diagram_of
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import read_models
from modallab.pipelines.parameters import parse_parameters
from modallab.pipelines.report import report_content
from modallab.reporting.report import write_report

DATA = ROOT / "tests/data"
HITS = DATA / "hammer_5hits.h5"
MADE = ROOT / "docs/made.py"


def helped(capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit):
        main(["identify", "--help"])
    return capsys.readouterr().out


def tables() -> str:
    import runpy

    made = runpy.run_path(str(MADE))
    return str(made["estimators"]() + made["commands"]())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "more").mkdir()
    write_example("add-an-estimator.md", tmp_path / "more/phase_slope.py")
    return tmp_path / "more"


def test_it_is_offered_everywhere_and_gone_without_its_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = helped(capsys), tables()
    with added(estimators, folder):
        assert "phase_slope" in helped(capsys)
        assert parse_parameters("identify", {"method": "phase_slope"}).options().method == "phase_slope"
        assert "| `phase_slope` | peak search, and damping from the slope" in tables()
        assert "{circle,era,peak,phase_slope,plscf}" in tables()
    assert (helped(capsys), tables()) == before
    assert "phase_slope" not in "".join(before)
    with pytest.raises(JobError, match="'circle', 'era', 'peak' or 'plscf'"):
        parse_parameters("identify", {"method": "phase_slope"})
    with pytest.raises(IdentificationError, match="no estimator 'phase_slope'"):
        IdentificationOptions(method="phase_slope")


@pytest.mark.thorough("identifies a whole campaign, and reports it")
def test_it_identifies_is_reported_and_its_models_stay_readable(folder: Path, tmp_path: Path) -> None:
    written = tmp_path / "models.json"
    with added(estimators, folder):
        band = ["--band", "500", "1500", "--json", str(written)]
        assert main(["identify", str(HITS), "--method", "phase_slope", *band]) == 0
        (own,) = read_models(written)
        assert any("those of the slope of the phase, not refined" in note for note in own.notes)
        campaign = read_campaign(HITS, read_rig(DATA / "hammer_rig.yaml"))
        refined = identify_campaign(
            campaign, IdentificationOptions(method="phase_slope", band_hz=(500.0, 1500.0), refine=True)
        )
        beside = identify_campaign(campaign, IdentificationOptions(method="peak", band_hz=(500.0, 1500.0), refine=True))
        one, other = refined.identified[0].model, beside.identified[0].model
        assert np.all(np.abs(one.frequency_hz - other.frequency_hz) < 0.1 * other.frequency_sigma_hz)
        assert np.all(np.abs(one.damping_ratio - other.damping_ratio) < 0.1 * other.damping_sigma)
        np.testing.assert_allclose(own.frequency_hz, one.frequency_hz, rtol=2e-3)
        np.testing.assert_allclose(own.damping_ratio, one.damping_ratio, rtol=0.6)
        assert not isinstance(diagram_of(campaign, refined.identified[0]), str)
        write_report(tmp_path / "with.html", report_content(campaign, refined, "With"))
        assert "Impact: slope of the phase, " in (tmp_path / "with.html").read_text(encoding="utf-8")
    (again,) = read_models(written)
    assert again.method == "phase_slope"
    assert json.loads(written.read_text())["models"][0]["method"] == "phase_slope"
    write_report(tmp_path / "without.html", report_content(campaign, refined, "Without"))
    assert "Impact: phase_slope, " in (tmp_path / "without.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", estimator_names())
def test_every_estimator_declares_all_that_it_must(name: str) -> None:
    """A declaration that lacks something cannot be made; see below."""
    assert find_estimator(name).name == name


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"source": ""}, "does not declare source"),
        ({"description": " ", "called": ""}, "does not declare called, description"),
        ({"poles": None}, "does not declare either an order or poles"),
        ({"order": find_estimator("plscf").order}, "does not declare either an order or poles"),
        ({"damping": False}, "does not declare a source of damping"),
    ],
)
def test_what_a_declaration_lacks_is_said_in_a_sentence(change: dict[str, object], sentence: str) -> None:
    with pytest.raises(ConfigurationError, match=sentence) as caught:
        replace(find_estimator("circle"), **change)
    assert "'circle'" in str(caught.value)


def test_limits_of_an_order_are_declared_in_full() -> None:
    order = find_estimator("plscf").order
    assert order is not None
    for wrong in ({"lowest": 1}, {"highest": 1}, {"default": ""}):
        with pytest.raises(ConfigurationError, match="limits of its order"):
            replace(find_estimator("plscf"), order=replace(order, **wrong))


@pytest.mark.parametrize(("method", "order"), [("plscf", 401), ("era", 1), ("plscf", 0)])
def test_an_order_outside_the_limits_is_rejected_by_options_and_jobs(method: str, order: int) -> None:
    for ask in (
        lambda: IdentificationOptions(method=method, max_order=order),
        lambda: parse_parameters("identify", {"method": method, "max_order": order}),
    ):
        with pytest.raises(ModallabError):
            ask()


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("X = 1\n", "declares no ESTIMATOR"),
        ("from modallab.identification.estimators.era import ESTIMATOR\n", "declares itself as 'era'"),
    ],
)
def test_a_file_that_declares_nothing_or_another_is_rejected(tmp_path: Path, content: str, sentence: str) -> None:
    (tmp_path / "mute.py").write_text(content)
    with added(estimators, tmp_path), pytest.raises(ConfigurationError, match=sentence):
        find_estimator("mute")
