"""A map says which variable of a MATLAB file is what; without one only what leaves no choice is taken."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exchange_records import RATE_HZ, hit, times
from exchange_rigs import beam_rig
from numpy.typing import NDArray
from scipy import io
from test_import_arrays import save_7_3

import modallab as ml
from modallab.cli import main
from modallab.core.errors import DataError, FormatError
from modallab.formats.arrays.array_map import map_of, parse_map
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.importer import draft_rig, import_sources
from modallab.formats.options import ImportOptions
from modallab.formats.rig.rig_file import read_rig

RIG = beam_rig()
LINES = np.arange(1.0, 41.0)


def frfs(outputs: int = 3, inputs: int = 2) -> NDArray[np.complex128]:
    """(outputs, inputs, lines), no two alike."""
    s = 2j * np.pi * LINES
    each = np.arange(1, outputs * inputs + 1).reshape(outputs, inputs, 1)
    return each * s**2 / (s**2 + 4 * s + (2 * np.pi * (9 + each)) ** 2)


def save_5(path: Path, **variables: Any) -> Path:
    io.savemat(path, variables)
    return path


def mapped(path: Path, content: dict[str, Any], rig: Any = RIG) -> Any:
    options = ImportOptions(array_map=map_of(content, "map"))
    return import_sources([path], rig or draft_rig(path, options), options)


@pytest.mark.parametrize("save", [save_5, save_7_3])
@pytest.mark.parametrize(
    "axes", [("outputs", "inputs", "lines"), ("lines", "outputs", "inputs"), ("inputs", "lines", "outputs")]
)
def test_the_axes_of_frfs_stand_in_any_order(tmp_path: Path, save: Any, axes: tuple[str, ...]) -> None:
    standard = ("outputs", "inputs", "lines")
    turned = np.transpose(frfs(), [standard.index(a) for a in axes])
    path = save(tmp_path / "x.mat", MyFrf=turned, omega=2 * np.pi * LINES)
    content = {"frf": "MyFrf", "frequency": "omega", "frequency_unit": "rad/s", "axes": axes, "inputs": [1, 3]}
    (frf,) = mapped(path, content).frfs
    np.testing.assert_allclose(frf.values, frfs(), rtol=1e-12)
    np.testing.assert_allclose(frf.frequency_hz, LINES)
    assert frf.input_points == (1, 3)


def test_units_and_outputs_are_those_of_the_map(tmp_path: Path) -> None:
    path = save_5(tmp_path / "x.mat", data={"H": frfs()[::-1, 0], "f": LINES})
    content = {"frf": "data.H", "frequency": "data.f", "axes": ["outputs", "lines"], "inputs": [2], "unit": "g/N"}
    (frf,) = mapped(path, content | {"outputs": ["a03", 2, "a01"]}).frfs
    assert frf.outputs == ("a03", "a02", "a01")
    np.testing.assert_allclose(frf.values[:, 0], 9.80665 * frfs()[::-1, 0], rtol=1e-12)


def test_one_axis_of_one_element_may_be_missing(tmp_path: Path) -> None:
    path = save_5(tmp_path / "x.mat", H=frfs(3, 1), f=LINES)
    content = {"frf": "H", "frequency": "f", "axes": ["outputs", "inputs", "lines"], "inputs": [2]}
    np.testing.assert_array_equal(mapped(path, content).frfs[0].values, frfs(3, 1))


def test_many_hits_in_one_array_are_as_many_records(tmp_path: Path) -> None:
    hits = np.stack([hit(4, seed=k) for k in range(5)])
    path = save_5(tmp_path / "x.mat", force=hits[:, 0].T, acc=hits[:, 1:].transpose(2, 0, 1), t=times())
    content = {"time": "t", "force": "force", "responses": "acc", "axes": ["samples", "records", "outputs"]}
    campaign = mapped(path, content | {"response_unit": "g", "inputs": [2]})
    np.testing.assert_array_equal([b.samples for b in campaign.blocks], hits)
    assert {(b.rate_hz, b.drive_point, b.units) for b in campaign.blocks} == {(RATE_HZ, 2, ("N", "g", "g", "g"))}


def test_a_map_at_the_terminal_makes_the_rig_too(tmp_path: Path) -> None:
    path, out = save_5(tmp_path / "x.mat", run={"H": frfs().transpose(2, 0, 1), "w": LINES}), tmp_path / "c.h5"
    (tmp_path / "map.yaml").write_text(
        "frf: run.H\nfrequency: run.w\naxes: [lines, outputs, inputs]\nunit: m/N\noutputs: [4, 5, 6]\ninputs: [5, 6]\n"
    )
    assert main(["import", str(path), "--map", str(tmp_path / "map.yaml"), "--out", str(out)]) == 0
    (frf,) = read_campaign(out).frfs
    assert (frf.quantity, frf.output_points, frf.input_points) == ("receptance", (4, 5, 6), (5, 6))
    assert [c.quantity for c in read_rig(tmp_path / "c.rig.yaml").channels] == ["force", *["displacement"] * 3]


def test_records_without_a_choice_need_no_map(tmp_path: Path) -> None:
    rows = hit(4)
    path = save_5(tmp_path / "x.mat", rec={"force": rows[0], "acc": rows[1:].T}, t=times(), remark="any")
    recording = ml.load(path)
    assert [c.name for c in recording.rig.channels] == ["rec.force", "rec.acc:1", "rec.acc:2", "rec.acc:3"]
    np.testing.assert_array_equal(recording.campaign.blocks[0].samples, rows)


def test_frfs_of_one_force_need_no_map(tmp_path: Path) -> None:
    path = save_7_3(tmp_path / "x.mat", H=frfs()[:, 0], freq=LINES)
    (frf,) = ml.load(path).campaign.frfs
    np.testing.assert_array_equal(frf.values, frfs()[:, :1])


@pytest.mark.parametrize(
    ("variables", "words"),
    [
        ({"H": frfs(), "f": LINES}, "axes are not known; there are H 3x2x40, f 40"),
        ({"y": hit(4), "t": times()}, "which column is the force; there are y 4x256, t 256"),
        ({"y": hit(4)}, "neither frequency and FRF nor time or rate; there are y 4x256"),
        ({"a": hit(2)[0], "b": hit(2)[1, :90], "t": times()}, "differ in length"),
    ],
)
def test_what_leaves_a_choice_is_asked_for_with_an_example(tmp_path: Path, variables: Any, words: str) -> None:
    with pytest.raises(DataError, match=words) as caught:
        draft_rig(save_5(tmp_path / "x.mat", **variables))
    assert "--map map.yaml, such as {frf: data.H" in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"frf": "H"}, "names no frequency"),
        ({"frf": "H", "frequency": "f", "axis": ["lines"]}, "axis is no field of a map; there are frf, frequency"),
        ({"frf": "H", "frequency": "f", "axes": ["samples", "lines"]}, "axes are samples, lines"),
        ({}, "neither or both"),
        ("text", "valid dictionary"),
    ],
)
def test_a_map_that_says_nothing_is_rejected(content: Any, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        map_of(content, "map.yaml")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"frf": "G", "frequency": "f"}, "has no array 'G'.*H 3x2x40"),
        ({"frf": "H", "frequency": "f", "axes": ["inputs", "outputs", "lines"]}, "shape .3, 2, 40.*with 3 outputs"),
        ({"frf": "H", "frequency": "f", "outputs": ["b"], "axes": ["lines"]}, "output 'b' of the map is no channel"),
        ({"frf": "H", "frequency": "f", "unit": "N/m", "axes": ["outputs", "inputs", "lines"]}, "'N/m' is none of"),
    ],
)
def test_a_map_that_does_not_fit_says_where(tmp_path: Path, content: Any, words: str) -> None:
    path = save_5(tmp_path / "x.mat", H=frfs(), f=LINES)
    with pytest.raises(DataError, match=f"(?s){words}"):
        mapped(path, content)


def test_the_text_of_a_map_is_as_good_as_its_file() -> None:
    said = "{time: q, force: hammer, responses: readings, axes: [samples, outputs]}"
    assert parse_map(said, "query").axes == ("samples", "outputs")
    with pytest.raises(FormatError, match="is no YAML"):
        parse_map("{time: q", "query")
    with pytest.raises(FormatError, match="tyme is no field"):
        parse_map("{tyme: q, responses: readings}", "query")
