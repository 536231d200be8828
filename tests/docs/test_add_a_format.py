"""A format is one file: with it, import and export know it; without it, they do not."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from added_file import added, write_example
from pages import ROOT

from modallab.cli import main
from modallab.core.errors import ConfigurationError, DataError, FormatError
from modallab.formats import all_formats, import_sources, known, read_campaign, read_rig, readers, write_export, writers
from modallab.formats.options import ImportOptions
from modallab.formats.rig.rig_file import write_rig

DATA = ROOT / "tests/data"
RIG = DATA / "hammer_rig.yaml"


def helped(command: str, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    return capsys.readouterr().out


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "more").mkdir()
    write_example("add-a-format.md", tmp_path / "more/columns.py")
    return tmp_path / "more"


def test_it_is_offered_everywhere_and_gone_without_its_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = helped("import", capsys), helped("export", capsys)
    with added(known, folder):
        assert "plain columns" in " ".join(helped("import", capsys).split())
        assert "{columns,csv,hdf5,sep005,tdms,uff}" in helped("export", capsys).replace("\n", "")
        table = runpy.run_path(str(ROOT / "docs/made.py"))["formats"]()
        assert "| `columns` | a line with the rate, then a line a sample | `.columns` |" in table
    assert (helped("import", capsys), helped("export", capsys)) == before
    assert "plain columns" not in " ".join("".join(before).split())


def test_what_it_writes_comes_back_and_no_other_format_takes_it(folder: Path, tmp_path: Path) -> None:
    # Records in volts need the sensitivity of each channel, which this rig file does not state.
    bare, rig = read_rig(RIG), tmp_path / "rig.yaml"
    stated = tuple(c.model_copy(update={"sensitivity_v_per_unit": 1.0}) for c in bare.channels)
    write_rig(bare.model_copy(update={"channels": stated}), rig)
    source = read_campaign(DATA / "hammer_5hits.h5", bare)
    one = replace(source, blocks=source.blocks[:1])
    out, back = tmp_path / "hit.data", tmp_path / "back.h5"
    with added(known, folder):
        assert write_export(one, out, "columns") == ()
        assert main(["import", str(out), "--rig", str(rig), "--out", str(back), "--volts"]) == 0
        (found,) = read_campaign(back).blocks
        np.testing.assert_array_equal(found.samples, one.blocks[0].samples * one.blocks[0].scale[:, None])
        assert found.rate_hz == one.blocks[0].rate_hz
        with pytest.raises(DataError, match="5 records, columns hold one"):
            write_export(source, out, "columns")
        (tmp_path / "cut.data").write_bytes(out.read_bytes()[:-20])
        (tmp_path / "other.columns").write_bytes(b"time,force\n0,1\n")
        for name, words in (("cut.data", "is damaged"), ("other.columns", "is no text of columns")):
            with pytest.raises(FormatError, match=words):
                import_sources([tmp_path / name], read_rig(RIG), ImportOptions(volts=True))
    with pytest.raises(DataError, match="'columns' is no format to write"):
        write_export(one, out, "columns")
    with pytest.raises(FormatError, match="is no number"):
        import_sources([out], read_rig(RIG), ImportOptions(volts=True))


@pytest.mark.parametrize("name", [f.name for f in all_formats()])
def test_every_format_declares_all_that_it_must(name: str) -> None:
    """A declaration that lacks something cannot be made; see below."""
    (found,) = (f for f in all_formats() if f.name == name)
    assert found in (*readers(), *writers())
    assert set(found.asks) <= set(ImportOptions.__slots__)


def test_the_order_in_which_formats_are_tried_is_declared_and_no_two_share_a_place() -> None:
    tried = [f.priority for f in readers()]
    assert tried == sorted(set(tried))
    order = ["mat", "wav", "netcdf", "hdf5_arrays", "hdf5", "npy", "lvm", "tdms", "sep005", "uff", "csv"]
    assert [f.name for f in readers()] == order


def test_no_two_formats_share_an_ending() -> None:
    endings = [ending for f in all_formats() for ending in f.endings]
    assert len(endings) == len(set(endings))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"title": "", "is_no": " "}, "does not declare title, is_no"),
        ({"holds": ()}, "does not declare what it holds"),
        ({"endings": ()}, "does not declare endings"),
        ({"endings": ("CSV",)}, "does not declare endings"),
        ({"read": None, "write": None, "fits": None}, "does not declare a reader or a writer"),
        ({"fits": None}, "does not declare a reader together with what fits it"),
        ({"priority": 0}, "and a priority from 1 on"),
    ],
)
def test_what_a_declaration_lacks_is_said_in_a_sentence(change: dict[str, object], sentence: str) -> None:
    (csv,) = (f for f in all_formats() if f.name == "csv")
    with pytest.raises(ConfigurationError, match=sentence) as caught:
        replace(csv, **change)
    assert "'csv'" in str(caught.value)


def test_a_file_that_declares_nothing_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "mute.py").write_text("X = 1\n")
    with added(known, tmp_path), pytest.raises(ConfigurationError, match="declares no FORMAT"):
        all_formats()
