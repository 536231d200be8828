"""`modallab import` writes a campaign and says what it read, or says what is wrong and writes nothing."""

from pathlib import Path

import numpy as np
import pytest
from exchange_records import DATA, hit, times

from modallab.cli import main
from modallab.formats.campaign.campaign_hdf5 import read_campaign

RIG = str(DATA / "hammer_rig.yaml")


def save(folder: Path, rows: np.ndarray, name: str = "hit_1.npy") -> str:
    np.save(folder / name, rows)
    return str(folder / name)


@pytest.fixture
def good() -> np.ndarray:
    return np.vstack([times(), hit(2)])


def test_what_was_read_is_reported_and_written(
    tmp_path: Path, good: np.ndarray, capsys: pytest.CaptureFixture[str]
) -> None:
    sources = [save(tmp_path, good, f"hit_{k}.npy") for k in (1, 2, 3)]
    out = tmp_path / "campaign.h5"
    assert main(["import", *sources, "--rig", RIG, "--out", str(out)]) == 0
    reported = capsys.readouterr().out
    for words in ("3", "impact", "2000", "0.128", "N (force)", "m/s^2"):
        assert words in reported
    assert [b.name for b in read_campaign(out).blocks] == ["hit_1", "hit_2", "hit_3"]


def test_options_say_what_the_files_do_not(tmp_path: Path, good: np.ndarray) -> None:
    out = tmp_path / "campaign.h5"
    rig = str(DATA / "campaign_v1" / "rig.yaml")
    options = ["--rate", "500", "--test", "sine", "--drive-point", "2", "--volts"]
    assert main(["import", save(tmp_path, hit(4)), "--rig", rig, "--out", str(out), *options]) == 0
    (block,) = read_campaign(out).blocks
    assert (block.rate_hz, block.test, block.drive_point, block.units) == (500.0, "sine", 2, ("V",) * 4)


def test_copied_channels_are_noted(tmp_path: Path, good: np.ndarray, capsys: pytest.CaptureFixture[str]) -> None:
    good[2] = good[1]
    out = tmp_path / "campaign.h5"
    assert main(["import", save(tmp_path, good), "--rig", RIG, "--out", str(out)]) == 0
    assert "note: hit_1: channels force and acceleration agree in every bit" in capsys.readouterr().out


def test_bad_input_gives_exit_code_2_and_no_file(
    tmp_path: Path, good: np.ndarray, capsys: pytest.CaptureFixture[str]
) -> None:
    good[2, 5] = np.nan
    folder = tmp_path / "out"
    folder.mkdir()
    assert main(["import", save(tmp_path, good), "--rig", RIG, "--out", str(folder / "c.h5")]) == 2
    reported = capsys.readouterr().err
    assert "hit_1.npy, record hit_1: channel acceleration: 1 of 256 samples are NaN" in reported
    assert "what to do: " in reported
    assert list(folder.iterdir()) == []


def test_bad_input_leaves_an_older_campaign_as_it_was(tmp_path: Path, good: np.ndarray) -> None:
    out = tmp_path / "c.h5"
    assert main(["import", save(tmp_path, good), "--rig", RIG, "--out", str(out)]) == 0
    before = out.read_bytes()
    assert main(["import", save(tmp_path, good[:, ::-1]), "--rig", RIG, "--out", str(out)]) == 2
    assert out.read_bytes() == before


def test_a_bad_rig_gives_exit_code_2(tmp_path: Path, good: np.ndarray, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "rig.yaml").write_text("name: x\nmodel: unknown\nchannels: []\n")
    rig = str(tmp_path / "rig.yaml")
    assert main(["import", save(tmp_path, good), "--rig", rig, "--out", str(tmp_path / "c.h5")]) == 2
    assert "channels: found []; allowed: at least one entry" in capsys.readouterr().err
    assert not (tmp_path / "c.h5").exists()


def test_a_source_is_never_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "c.h5"
    source.write_bytes((DATA / "hammer_5hits.h5").read_bytes())
    assert main(["import", str(source), "--rig", RIG, "--out", str(source)]) == 2
    assert "is one of the sources and would be overwritten" in capsys.readouterr().err
    assert source.read_bytes() == (DATA / "hammer_5hits.h5").read_bytes()


def test_the_frequency_of_each_sine_is_given_at_import(
    tmp_path: Path, good: np.ndarray, capsys: pytest.CaptureFixture[str]
) -> None:
    sources = [save(tmp_path, good, f"sine_{k}.npy") for k in (1, 2)]
    out = tmp_path / "campaign.h5"
    command = ["import", *sources, "--rig", RIG, "--out", str(out), "--test", "sine", "--frequency"]
    assert main([*command, "40", "50.5"]) == 0
    assert [b.frequency_hz for b in read_campaign(out).blocks] == [40.0, 50.5]
    assert main([*command, "40", "50", "60"]) == 2
    assert "frequency: 3 values are given for 2 files" in capsys.readouterr().err
    assert main(["import", *sources, "--rig", RIG, "--out", str(out), "--frequency", "40"]) == 2
    assert "with --test sine" in capsys.readouterr().err


def test_an_exponential_window_is_of_frfs(tmp_path: Path, good: np.ndarray, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "campaign.h5"
    assert main(["import", save(tmp_path, good), "--rig", RIG, "--out", str(out), "--window", "0.5"]) == 2
    assert "there are no FRFs" in capsys.readouterr().err
