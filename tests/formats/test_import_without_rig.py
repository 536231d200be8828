"""What a file says of its own channels becomes a rig for the user to complete."""

import json
from pathlib import Path

import numpy as np
import pytest
import pyuff
from exchange_records import block, campaign, hit, times, uff_set, write_uff
from exchange_rigs import beam_rig

from modallab.cli import main
from modallab.core.errors import DataError, ModallabError
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.exporter import write_export
from modallab.formats.importer import draft_rig, import_recordings
from modallab.formats.rig.rig_file import read_rig
from modallab.formats.uff.uff_results import read_results
from modallab.formats.unit_text import frf_unit, normal_unit
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign

NODES = {"type": 15, "node_nums": [1, 2, 3, 4], "def_cs": [0] * 4, "disp_cs": [0] * 4, "color": [1] * 4}
SQUARE = NODES | {"x": [0.0, 1000.0, 1000.0, 0.0], "y": [0.0, 0.0, 500.0, 500.0], "z": [0.0, 0.0, 0.0, 250.0]}
MILLIMETRES = {
    "type": 164, "units_code": 5, "units_description": "mm", "temp_mode": 1,
    "length": 1000.0, "force": 1000.0, "temp": 1.0, "temp_offset": 273.15,
}  # fmt: skip
TRACE = {"type": 82, "trace_num": 1, "n_nodes": 6, "color": 1, "id": "edge", "nodes": np.array([1, 2, 3, 0, 3, 4])}
SHAPE = {
    "type": 55, "id1": "first", "id2": "NONE", "id3": "NONE", "id4": "NONE", "id5": "NONE", "model_type": 1,
    "analysis_type": 2, "data_ch": 2, "spec_data_type": 8, "data_type": 2, "n_data_per_node": 3, "load_case": 0,
    "mode_n": 1, "freq": 12.5, "modal_m": 1.0, "modal_damp_vis": 0.01, "modal_damp_his": 0.0,
    "node_nums": [1, 2, 3, 4], "r1": [0.0] * 4, "r2": [0.0] * 4, "r3": [0.0, 1.0, -1.0, 0.5],
}  # fmt: skip


def write(path: Path, *sets: dict) -> Path:
    file = pyuff.UFF(str(path))
    file._write_set(sets[0], "overwrite")
    for one in sets[1:]:
        file._write_set(one, "add")
    return path


def records(path: Path, *, force: bool = True) -> Path:
    rows = hit(4)
    said = {"ordinate_axis_units_lab": "N", "ordinate_spec_data_type": 13, "rsp_ent_name": "hammer", "rsp_node": 2}
    sets = [uff_set(rows[0], times(), 1, **said, rsp_dir=3)] if force else []
    axes = [(1, 3, "m/s^2"), (2, 1, "g"), (3, -2, "V")]
    for row, (node, axis, unit) in zip(rows[1:], axes, strict=True):
        sets.append(uff_set(row, times(), 1, rsp_node=node, rsp_dir=axis, ordinate_axis_units_lab=unit))
    return write_uff(path, *sets)


def test_the_drive_point_that_the_user_names_is_on_the_drafted_rig(tmp_path: Path) -> None:
    path = tmp_path / "hit.csv"
    rows = np.column_stack([times(), *hit(2)])
    np.savetxt(path, rows, delimiter=",", header="t,force,a1", comments="", fmt="%.9g")
    found = import_recordings([path], None, {"drive_point": 3})
    assert [point.id for point in found.rig.points] == [3]
    assert found.blocks[0].drive_point == 3


def test_names_units_nodes_and_directions_of_a_universal_file_make_a_rig(tmp_path: Path) -> None:
    path = records(tmp_path / "test.uff")
    rig = draft_rig(path)
    assert [c.quantity for c in rig.channels] == ["force", "acceleration", "acceleration", "voltage"]
    assert [c.unit for c in rig.channels] == ["N", "m/s^2", "g", "V"]
    assert [c.point for c in rig.channels] == [2, 1, 2, 3]
    assert [c.direction for c in rig.channels] == ["+z", "+z", "+x", "-y"]


def test_the_command_writes_the_rig_it_used_and_takes_it_back(tmp_path: Path, capsys) -> None:
    path, out = records(tmp_path / "test.uff"), tmp_path / "c.h5"
    assert main(["import", str(path), "--out", str(out)]) == 0
    assert "to be completed" in capsys.readouterr().out.replace("\n", " ")
    drafted = read_rig(tmp_path / "c.rig.yaml")
    assert read_campaign(out).rig == drafted
    assert main(["import", str(path), "--rig", str(tmp_path / "c.rig.yaml"), "--out", str(tmp_path / "d.h5")]) == 0


def test_responses_without_a_force_are_kept_and_an_identification_that_needs_it_says_so(tmp_path: Path) -> None:
    out = tmp_path / "c.h5"
    assert main(["import", str(records(tmp_path / "r.uff", force=False)), "--out", str(out)]) == 0
    campaign = read_campaign(out)
    assert campaign.rig.force is None
    assert campaign.blocks[0].test == "random"
    with pytest.raises(ModallabError, match=r"no force channel.*\n.*--response-only"):
        identify_campaign(campaign, IdentificationOptions())


def test_a_beam_needs_its_force(tmp_path: Path) -> None:
    content = draft_rig(records(tmp_path / "r.uff", force=False)).model_dump()
    with pytest.raises(ValueError, match="exactly one channel of quantity force"):
        Rig.model_validate(content | {"model": "cantilever"})


def test_a_table_names_its_channels(tmp_path: Path) -> None:
    rows = np.vstack([times(), hit(3)]).T
    head = "time [s],force [N],tip [g],mic [Pa]"
    np.savetxt(tmp_path / "t.csv", rows, delimiter=",", header=head, comments="", fmt="%.9g")
    assert [(c.name, c.quantity) for c in draft_rig(tmp_path / "t.csv").channels] == [
        ("force", "force"),
        ("tip", "acceleration"),
        ("mic", "pressure"),
    ]


def test_two_forces_are_named(tmp_path: Path) -> None:
    rows = np.vstack([times(), hit(3)]).T
    np.savetxt(tmp_path / "t.csv", rows, delimiter=",", header="time,f1 [N],f2 [N],a", comments="")
    with pytest.raises(DataError, match="2 channels of force: f1, f2"):
        draft_rig(tmp_path / "t.csv")


def test_an_array_says_nothing_of_its_channels(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.vstack([times(), hit(3)]))
    with pytest.raises(DataError, match="says nothing of its channels"):
        draft_rig(tmp_path / "a.npy")


def test_results_without_a_measurement_yield_geometry_in_metres_and_shapes(tmp_path: Path) -> None:
    path = write(tmp_path / "r.uff", MILLIMETRES, SQUARE, TRACE, SHAPE)
    found = read_results(path)
    assert found.geometry.points[4] == (0.0, 0.5, 0.25)
    assert found.geometry.lines == ((1, 2), (2, 3), (3, 4))
    assert main(["import", str(path), "--out", str(tmp_path / "r.h5")]) == 0
    (mode,) = json.loads((tmp_path / "r.json").read_text())["modes"]
    assert (mode["frequency_hz"], mode["shape"]["3"][2]) == (12.5, [-1.0, 0.0])
    page = (tmp_path / "r.html").read_text()
    assert 'data-lines="[[0,1],[1,2],[2,3]]"' in page
    assert not (tmp_path / "r.h5").exists()


def test_hysteretic_damping_counts_half_and_deflections_under_a_load_are_no_modes(tmp_path: Path, capsys) -> None:
    damped = SHAPE | {"modal_damp_his": 0.02}
    forced = SHAPE | {"analysis_type": 5, "freq_step_n": 1}
    assert (
        main(["import", str(write(tmp_path / "r.uff", SQUARE, damped, forced)), "--out", str(tmp_path / "r.h5")]) == 0
    )
    (mode,) = json.loads((tmp_path / "r.json").read_text())["modes"]
    assert mode["damping_ratio"] == pytest.approx(0.02)
    assert "1 sets are deflections under a load" in capsys.readouterr().out


def test_a_psd_alone_is_rejected_in_one_sentence(tmp_path: Path, capsys) -> None:
    path = write_uff(tmp_path / "p.uff", uff_set(np.abs(hit(2)[1]), times(), 9))
    assert main(["import", str(path), "--out", str(tmp_path / "p.h5")]) == 2
    assert "only PSD" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["1/N)*(m/s²", "(1/N)*(m/s^2)", "(m/s^2)/N", "m/s²/N"])
def test_units_that_lost_a_bracket_are_understood(text: str) -> None:
    assert frf_unit(normal_unit(text), "") == ("inertance", 1.0)


@pytest.mark.parametrize(("kind", "name"), [("tdms", "t.tdms"), ("sep005", "t.json")])
def test_names_and_units_of_other_programs_make_a_rig(tmp_path: Path, kind: str, name: str) -> None:
    rig = beam_rig()
    units = tuple(c.unit for c in rig.channels)
    known = campaign(rig, block(rig, hit(4), units=units, scale=np.ones(4)))
    write_export(known, tmp_path / name, kind)
    rig = draft_rig(tmp_path / name)
    assert [(c.name, c.quantity) for c in rig.channels] == [(c.name, c.quantity) for c in beam_rig().channels]
    assert main(["import", str(tmp_path / name), "--out", str(tmp_path / "c.h5")]) == 0
    assert read_campaign(tmp_path / "c.h5").rig == read_rig(tmp_path / "c.rig.yaml")
