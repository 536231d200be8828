"""`modallab model` predicts what the same model predicts from Python."""

import json
from pathlib import Path

import numpy as np
import pytest
from chain import BARE

from modallab.cli import main
from modallab.formats.frf_file import bare_rig
from modallab.formats.rig.rig_file import write_rig
from modallab.modification.attachments import Element
from modallab.modification.known import Known
from modallab.modification.participation import participation


@pytest.fixture
def models(tmp_path: Path) -> Path:
    path = tmp_path / "models.json"
    path.write_text(json.dumps({"models": [BARE.model().model_dump(mode="json")]}))
    return path


def test_a_mass_moves_modes_as_from_python(models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer = tmp_path / "answer.json"
    assert main(["model", "modify", str(models), "--mass", "0.4", "--at", "3", "--json", str(answer)]) == 0
    expected = Known(BARE.model()).with_changes([Element(3, mass=0.4)]).modes.frequency_hz
    np.testing.assert_allclose(json.loads(answer.read_text())["frequency_hz"], expected)
    assert "mass 0.4 kg at 3" in capsys.readouterr().out


def test_a_prediction_stands_beside_what_was_measured(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_rig(bare_rig(BARE.model().outputs, [1, 2, 3, 4], [1], "inertance"), tmp_path / "rig.yaml")
    given = ["model", "modify", str(models), "--mass", "0.0001", "--at", "3", "--check", str(models)]
    assert main(given) == 0
    assert "Mode 1: predicted " in capsys.readouterr().out


def test_a_table_says_at_which_points_a_mode_is_brought_to_a_frequency(
    models: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "tune", str(models), "--mode", "1", "--to", "10.5", "--by", "mass"]) == 0
    assert "mass [kg]" in capsys.readouterr().out


def test_frfs_are_written_at_pairs_that_were_not_measured(models: Path, tmp_path: Path) -> None:
    out = tmp_path / "smooth.mat"
    assert main(["model", "frf", str(models), "--outputs", "2", "--inputs", "4", "--out", str(out)]) == 0
    assert out.exists()


def test_a_change_without_a_point_says_what_is_missing(models: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "modify", str(models), "--mass", "0.4"]) != 0
    assert "--at POINT" in capsys.readouterr().err


def test_shares_and_nodes_are_those_of_python(models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer = tmp_path / "answer.json"
    where = ["--at", "1", "--of", "3", "--band", "3", "40"]
    assert main(["model", "participation", str(models), *where, "--json", str(answer)]) == 0
    known = Known(BARE.model())
    expected = participation(known.structure, known.samples.first(5), 1, 3, band_hz=(3.0, 40.0))
    np.testing.assert_allclose(json.loads(answer.read_text())["share"], expected.share)
    assert main(["model", "nodes", str(models)]) == 0
    assert "Hit or mount a sensor at point" in capsys.readouterr().out


def test_a_moving_picture_needs_the_places_of_the_points(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "shape", str(models), "--mode", "1", "--out", str(tmp_path / "mode.gif")]) != 0
    assert "--rig" in capsys.readouterr().err
    assert main(["model", "shape", str(models), "--mode", "1"]) == 0
    assert "kg^-1/2" in capsys.readouterr().out


def test_a_model_compared_with_itself_has_a_mac_of_one(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "compare", str(models), "--other", str(models)]) != 0
    assert "--rig" in capsys.readouterr().err
    model, answer = BARE.model(), tmp_path / "answer.json"
    write_rig(bare_rig(model.outputs, [1, 2, 3, 4], [1], "inertance"), tmp_path / "rig.yaml")
    picture = ["--out", str(tmp_path / "pairs.svg")]
    assert main(["model", "compare", str(models), "--other", str(models), "--json", str(answer), *picture]) == 0
    assert "<svg" in (tmp_path / "pairs.svg").read_text()
    found = json.loads(answer.read_text())
    assert found["pairs"] == [[1, 1], [2, 2], [3, 3], [4, 4]]
    np.testing.assert_allclose(found["comac"], 1)


def test_a_correction_does_not_see_the_modes_held_out(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    function = tmp_path / "chain_model.py"
    function.write_text(
        "import numpy as np\n"
        "from scipy.linalg import eigh\n"
        "from chain import BARE\n"
        "from modallab import Prior\n"
        "priors = {'k': Prior(1.2, 0.2, True)}\n"
        "def predict(numbers):\n"
        "    squares, shapes = eigh(numbers['k'] * BARE.stiffness, BARE.mass)\n"
        "    return np.sqrt(squares) / 2 / np.pi, shapes.T\n"
    )
    answer = tmp_path / "answer.json"
    given = ["--fe", str(function), "--hold-out", "2", "--json", str(answer)]
    assert main(["model", "update", str(models), *given]) == 0
    found = json.loads(answer.read_text())
    assert found["parameters"]["k"]["found"] == pytest.approx(1.0, abs=0.01)
    assert found["held_out"] == [2]
    assert "held out" in capsys.readouterr().out
    assert main(["model", "update", str(models), "--prior", "E", "one", "5%"]) != 0
    assert "--prior density 7850 2%" in capsys.readouterr().err
