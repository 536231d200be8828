"""`modallab model` predicts what the same model predicts from Python."""

import json
from pathlib import Path

import numpy as np
import pytest
from chain import BARE, OTHER
from scipy.io import loadmat

import modallab as ml
from modallab.cli import main
from modallab.core.units import Quantity
from modallab.formats.frf_file import rig_without_places
from modallab.formats.rig.rig_file import write_rig
from modallab.modification.attachments import Element, RigidLink, TunedAbsorber
from modallab.modification.coupled import CouplingToStructure
from modallab.modification.known import KnownStructure
from modallab.modification.participation import modal_participation
from modallab.modification.structure import At


@pytest.fixture
def models(tmp_path: Path) -> Path:
    path = tmp_path / "models.json"
    path.write_text(json.dumps({"models": [BARE.model().model_dump(mode="json")]}))
    return path


def test_a_mass_moves_modes_as_from_python(models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    answer = tmp_path / "answer.json"
    assert main(["model", "modify", str(models), "--mass", "0.4", "--at", "3", "--json", str(answer)]) == 0
    expected = KnownStructure(BARE.model()).with_changes([Element(3, mass=0.4)]).modes.frequency_hz
    np.testing.assert_allclose(json.loads(answer.read_text())["frequency_hz"], expected)
    assert "mass 0.4 kg at 3" in capsys.readouterr().out


def test_several_changes_act_at_once(models: Path, tmp_path: Path) -> None:
    answer = tmp_path / "answer.json"
    masses = ["--mass", "0.4", "0.2", "--spring", "900", "--at", "3", "1"]
    more = ["--absorber", "2", "0.1", "9", "5", "--absorber", "4", "0.05", "20", "5", "--ground", "4"]
    assert main(["model", "modify", str(models), *masses, *more, "--json", str(answer)]) == 0
    hung = [Element(3, mass=0.4, spring=900), Element(1, mass=0.2, spring=900)]
    absorbers = [TunedAbsorber(2, 0.1, 9, 0.05), TunedAbsorber(4, 0.05, 20, 0.05)]
    expected = KnownStructure(BARE.model()).with_changes([*hung, *absorbers, RigidLink(4)]).modes.frequency_hz
    np.testing.assert_allclose(json.loads(answer.read_text())["frequency_hz"], expected)


def test_sizes_that_are_neither_one_nor_one_for_each_point_are_rejected(
    models: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "modify", str(models), "--mass", "0.4", "0.2", "--at", "1", "2", "3"]) != 0
    assert "one for each point" in capsys.readouterr().err


def test_a_prediction_stands_beside_what_was_measured(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_rig(rig_without_places(BARE.model().outputs, [1, 2, 3, 4], [1], "inertance"), tmp_path / "rig.yaml")
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
    known = KnownStructure(BARE.model())
    expected = modal_participation(known, 1, 3, band_hz=(3.0, 40.0))
    np.testing.assert_allclose(json.loads(answer.read_text())["share"], expected.share)
    assert main(["model", "nodes", str(models)]) == 0
    assert "Hit or mount a sensor at point" in capsys.readouterr().out


def test_a_reduction_is_that_of_python_and_needs_the_measured_frfs(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["model", "reduction", str(models)]) != 0
    assert "name the campaign instead of its models" in capsys.readouterr().err
    hz, answer = np.arange(0.5, 60, 0.05), tmp_path / "answer.json"
    s = 2j * np.pi * hz
    mobility = np.moveaxis((BARE.receptance(s) * s[:, None, None])[:, :, [0]], 0, -1)
    measured = ml.frf(hz, mobility, inputs=[1], quantity="mobility")
    path = measured.save(tmp_path / "measured.h5")
    assert main(["model", "reduction", str(path), "--json", str(answer)]) == 0
    found = json.loads(answer.read_text())
    assert found["measured_numbers"] == 2 * measured.frf.values.size > 10 * found["model_numbers"]
    assert np.shape(found["error"]) == measured.frf.values.shape[:2]
    assert "error [%]" in capsys.readouterr().out


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
    write_rig(rig_without_places(model.outputs, [1, 2, 3, 4], [1], "inertance"), tmp_path / "rig.yaml")
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


def test_a_response_is_printed_written_and_that_of_python(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    force, answer, out = tmp_path / "force.csv", tmp_path / "answer.json", tmp_path / "motion.csv"
    samples = np.random.default_rng(0).standard_normal((400, 2))
    np.savetxt(force, samples, delimiter=",")
    given = ["--at", "1", "4", "--of", "2", "--force", str(force), "--step", "0.01", "--displaced", "3", "0.001"]
    assert main(["model", "response", str(models), *given, "--json", str(answer), "--out", str(out)]) == 0
    start: dict[Quantity, dict[At, float]] = {"displacement": {3: 0.001}}
    expected = KnownStructure(BARE.model()).response(samples.T, 0.01, [1, 4], [2], start=start)
    written = np.loadtxt(out, delimiter=",", skiprows=1)
    np.testing.assert_allclose(written[:, 1], expected[0], rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(json.loads(answer.read_text())["peak"], np.abs(expected).max(axis=1))
    assert "acceleration in m/s^2 over 4 s" in capsys.readouterr().out


@pytest.mark.parametrize(
    "kind", [["--impulse", "0.1"], ["--sine", "10", "2"], ["--sweep", "2", "20", "1"], ["--random", "SPECTRUM"]]
)
def test_a_force_of_a_kind_lasts_as_long_as_is_said(
    models: Path, tmp_path: Path, kind: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    spectrum = tmp_path / "spectrum.csv"
    spectrum.write_text("1,0.01\n30,0.02\n")
    given = [str(spectrum) if word == "SPECTRUM" else word for word in kind]
    asked = ["model", "response", str(models), "--at", "1", "--step", "0.01", *given]
    assert main(asked) != 0
    assert "--seconds 10" in capsys.readouterr().err
    assert main([*asked, "--seconds", "4"]) == 0
    assert "over 4 s" in capsys.readouterr().out


def test_matrices_for_control_design_are_those_of_python(models: Path, tmp_path: Path) -> None:
    out = tmp_path / "model.mat"
    assert main(["model", "state-space", str(models), "--at", "1", "--of", "3", "--out", str(out)]) == 0
    found, expected = loadmat(out), KnownStructure(BARE.model()).state_space([1], [3], "acceleration")
    for name in ("A", "B", "C", "D", "frequency_sigma_hz"):
        np.testing.assert_allclose(found[name], np.atleast_2d(getattr(expected, name)))
    assert found["outputs"][0].strip() == "acceleration 3 [m/s^2]"


def test_what_is_coupled_and_taken_away_again_are_the_modes_of_python(models: Path, tmp_path: Path) -> None:
    other, answer = tmp_path / "other.json", tmp_path / "answer.json"
    other.write_text(json.dumps({"models": [OTHER.model().model_dump(mode="json")]}))
    given = ["--other", str(other), "--pair", "4", "1", "--joint", "30000", "--json", str(answer)]
    assert main(["model", "couple", str(models), *given]) == 0
    held = CouplingToStructure(KnownStructure(OTHER.model()).structure, [(4, 1)], 3e4)
    expected = KnownStructure(BARE.model()).with_changes([held]).modes.frequency_hz
    np.testing.assert_allclose(json.loads(answer.read_text())["frequency_hz"], expected)


def test_a_band_is_kept_free_and_an_absorber_found(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answer = tmp_path / "answer.json"
    given = ["--band", "10.5", "11", "--by", "mass", "--at", "1", "3"]
    assert main(["model", "free", str(models), *given, "--json", str(answer)]) == 0
    assert len(json.loads(answer.read_text())["answers"]) == 2
    assert "leaves no mode from 10.5 to 11 Hz" in capsys.readouterr().out
    given = ["--mode", "1", "--at", "3", "--mass", "0.05"]
    assert main(["model", "absorber", str(models), *given, "--json", str(answer)]) == 0
    found = json.loads(answer.read_text())
    assert found["peak_after"] < found["peak_before"]
