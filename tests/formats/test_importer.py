"""Many files of any kind become one campaign, or one message with all that is wrong with them."""

import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from exchange_records import DATA, campaign, hit, times, write_hit_uff
from exchange_rigs import beam_rig, plain_rig

from modallab.core.errors import DataError, FormatError, ModallabError
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.format import readers, sniff
from modallab.formats.importer import import_sources
from modallab.formats.options import ImportOptions

RIG = beam_rig()


def save_hit(folder: Path, name: str, channels: int = 4, seed: int = 1) -> Path:
    rows = np.vstack([times(), hit(channels, seed=seed)])
    path = folder / name
    if path.suffix == ".csv":
        path.write_text(
            "time,force,a01,a02,a03\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in rows.T) + "\n"
        )
    else:
        np.save(path, rows)
    return path


def test_files_of_every_kind_stand_in_the_order_given(tmp_path: Path) -> None:
    write_campaign(campaign(RIG, provenance={"seed": "4"}), tmp_path / "old.h5")
    paths = [
        save_hit(tmp_path, "b.npy", seed=2),
        save_hit(tmp_path, "a.csv", seed=3),
        write_hit_uff(tmp_path / "c.uff", hit(4, seed=5), binary=True),
        tmp_path / "old.h5",
    ]
    read = import_sources(paths, RIG)
    assert [(b.name, b.order) for b in read.blocks] == [("b", 0), ("a", 1), ("c", 2), ("hit_1", 3)]
    bare = "no unit is written of force, a01, a02, a03: taken in N, m/s^2"
    notes = f"b.npy: {bare}\na.csv: {bare}"
    assert read.provenance == {"seed": "4", "sources": "b.npy\na.csv\nc.uff\nold.h5", "notes": notes}
    write_campaign(read, tmp_path / "new.h5")
    assert [b.name for b in read_campaign(tmp_path / "new.h5").blocks] == ["b", "a", "c", "hit_1"]


def test_a_folder_with_a_campaign_is_a_source() -> None:
    assert len(import_sources([DATA / "campaign_v1"], RIG).blocks) == 3


def test_records_of_the_same_name_get_names_of_their_own(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
    paths = [save_hit(tmp_path / folder, "hit.npy") for folder in ("one", "two")]
    assert [b.name for b in import_sources(paths, RIG).blocks] == ["hit", "hit_2"]


def test_the_real_hits_are_one_campaign_of_five_blocks(tmp_path: Path) -> None:
    original = read_campaign(DATA / "hammer_5hits.h5")
    paths: list[Path] = []
    for b in original.blocks:
        time_s = np.arange(b.n_samples) / b.rate_hz
        paths.append(tmp_path / f"{b.name}.npy")
        np.save(paths[-1], np.vstack([time_s, b.samples * b.scale[:, None]]))
    read = import_sources(paths, plain_rig())
    assert [b.rate_hz for b in read.blocks] == [25600.0] * 5
    for got, expected in zip(read.blocks, original.blocks, strict=True):
        np.testing.assert_array_equal(got.samples, expected.samples * expected.scale[:, None])


def test_a_drive_point_is_that_of_the_records_of_a_campaign_that_have_none() -> None:
    rig = beam_rig().model_copy(update={"channels": plain_rig().channels})
    read = import_sources([DATA / "hammer_5hits.h5"], rig, ImportOptions(drive_point=3))
    assert {b.drive_point for b in read.blocks} == {3}


def test_the_content_decides_what_a_file_is_not_its_ending(tmp_path: Path) -> None:
    npy, csv = save_hit(tmp_path, "b.npy"), save_hit(tmp_path, "a.csv")
    uff = write_hit_uff(tmp_path / "c.uff", hit(4))
    write_campaign(campaign(RIG), tmp_path / "d.h5")
    for kind, path in (("npy", npy), ("csv", csv), ("uff", uff), ("hdf5", tmp_path / "d.h5")):
        assert sniff(path.rename(path.with_suffix(".data"))).name == kind


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.npy", b"", "is empty"),
        ("a.csv", b"  \n\n", "is empty"),
        ("a.npy", b"time,force\n0,1\n", "is no NPY file"),
        ("a.h5", b"time,force\n0,1\n", "is no HDF5 file"),
        ("a.unv", b"time,force\n0,1\n", "is no universal file: it has no line '    -1'"),
        ("a.mat", b"MATLAB 5.0\x00\x01\x02", "is no MATLAB file of version 4, 5 or 7.3"),
        ("a.xyz", b"any\x00\x01\x02", "is of no known kind"),
        ("a.npz", b"PK\x03\x04\x14\x00", "is no whole archive of NPY files"),
    ],
)
def test_files_of_no_known_kind_are_reported(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FormatError) as caught:
        import_sources([tmp_path / name], RIG)
    assert words in str(caught.value)
    assert caught.value.where == str(tmp_path / name)
    assert caught.value.remedy


def test_a_folder_or_a_missing_file_is_reported(tmp_path: Path) -> None:
    for path, words in (
        (tmp_path, "is a folder, without campaign.h5"),
        (tmp_path / "no.npy", "cannot be read: No such"),
    ):
        with pytest.raises(FormatError, match=words):
            import_sources([path], RIG)


def test_everything_that_is_wrong_in_any_file_stands_in_one_message(tmp_path: Path) -> None:
    good = save_hit(tmp_path, "good.npy")
    short = save_hit(tmp_path, "short.npy", channels=2)
    (tmp_path / "cut.npy").write_bytes(good.read_bytes()[:500])
    spoilt = np.load(good)
    spoilt[1, 9] = np.nan
    np.save(tmp_path / "spoilt.npy", spoilt)
    with pytest.raises(ModallabError) as caught:
        import_sources([good, short, tmp_path / "cut.npy", tmp_path / "spoilt.npy", tmp_path / "no.npy"], RIG)
    message = str(caught.value)
    assert message.startswith("4 problems:")
    for words in (
        "short.npy: has 3 rows",
        "cut.npy: is no whole NPY",
        "channel force: 1 of 256 samples are NaN",
        "no.npy: cannot be read",
    ):
        assert words in message
    assert "good.npy" not in message


def test_a_record_with_a_dead_force_is_read_beside_others_and_rejected_where_all_are(tmp_path: Path) -> None:
    good = save_hit(tmp_path, "good.npy")
    dead = np.load(good)
    dead[1] = 0
    np.save(tmp_path / "dead.npy", dead)
    campaign = import_sources([good, tmp_path / "dead.npy"], RIG)
    assert [block.name for block in campaign.blocks] == ["good", "dead"]
    with pytest.raises(DataError, match="record dead: channel force is dead"):
        import_sources([tmp_path / "dead.npy"] * 2, RIG)


def test_no_sources_are_no_campaign() -> None:
    with pytest.raises(DataError, match="no recordings were given"):
        import_sources([], RIG)


def test_the_page_knows_the_format_of_every_ending_that_is_read() -> None:
    page = files("modallab.service").joinpath("page/views/campaigns.js").read_text(encoding="utf-8")
    listed = dict(re.findall(r'(\w+): "(\.[^"]*)"', page.partition("const ENDINGS")[2].partition("\n")[0]))
    assert {name: set(text.split()) for name, text in listed.items()} == {f.name: set(f.endings) for f in readers()}
