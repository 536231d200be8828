"""`modallab export`: from a file or a data folder, with FRFs and modes."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import pyuff

from modallab.cli import main
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.importer import import_sources
from modallab.formats.rig.rig_file import read_rig

DATA = Path(__file__).parents[1] / "data"
HITS, RIG = DATA / "hammer_5hits.h5", DATA / "hammer_rig.yaml"


def test_real_hits_leave_and_come_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = read_campaign(HITS, read_rig(RIG))
    for format_ in ("hdf5", "uff", "tdms"):
        out = tmp_path / f"hits.{format_}"
        assert main(["export", str(HITS), "--rig", str(RIG), "--format", format_, "--out", str(out)]) == 0
        found = import_sources([out], read_rig(RIG))
        for one, other in zip(source.blocks, found.blocks, strict=True):
            np.testing.assert_array_equal(other.samples * other.scale[:, None], one.samples * one.scale[:, None])
            assert (other.rate_hz, other.test, other.name) == (one.rate_hz, one.test, one.name)
    assert "uff: 5 records, 0 FRF matrices" in capsys.readouterr().out


def test_measured_frfs_go_along(tmp_path: Path) -> None:
    out = tmp_path / "hits.uff"
    assert main(["export", str(HITS), "--rig", str(RIG), "--format", "uff", "--out", str(out), "--frf"]) == 0
    sets = [s for s in pyuff.UFF(str(out)).read_sets() if s["type"] == 58]
    assert [s["func_type"] for s in sets] == [1] * 10 + [4, 6]
    assert np.abs(sets[-2]["data"]).max() > 0
    assert 0.9 < np.median(sets[-1]["data"]) <= 1


def test_a_run_of_a_data_folder_is_exported(tmp_path: Path) -> None:
    data = Path(shutil.copytree(DATA / "store_v1", tmp_path / "data"))
    run = min(path.stem for path in (data / "runs").glob("*.h5"))
    out = tmp_path / "run.h5"
    assert main(["export", str(data), "--run", run, "--format", "hdf5", "--out", str(out)]) == 0
    assert [block.name for block in read_campaign(out).blocks] == ["impact_p01_1", "impact_p01_3"]


def test_what_cannot_be_exported_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(tmp_path / "no"), "--format", "uff", "--out", str(tmp_path / "x")]) == 2
    models = tmp_path / "models.json"
    models.write_text("{}")
    command = ["export", str(HITS), "--rig", str(RIG), "--format", "uff", "--out", str(tmp_path / "x")]
    assert main([*command, "--models", str(models)]) == 2
    said = capsys.readouterr().err
    assert "cannot be read" in said
    assert "holds no models: 'models'" in said
    assert not (tmp_path / "x").exists()
