"""Campaign files: every version stays readable, what is written comes back, what is damaged is rejected."""

import errno
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from exchange_records import DATA, block, campaign, counts, hit, receptances
from exchange_rigs import beam_rig, plain_rig

from modallab.core.block import Campaign
from modallab.core.errors import DataError, DiskFullError, FormatError, ModallabError, RigError, StorageError
from modallab.core.frf import Frf
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.rig.rig_file import write_rig

RIG = beam_rig()


def rejected(kind: type[ModallabError], path: Path, *args: Any) -> str:
    with pytest.raises(kind) as caught:
        read_campaign(path, *args)
    assert str(path) in str(caught.value)
    assert caught.value.remedy
    return str(caught.value)


def assert_same(one: Any, other: Any) -> None:
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)
        else:
            assert a == b, field.name


def test_version_1_reads_for_ever() -> None:
    read = read_campaign(DATA / "campaign_v1")
    assert [b.name for b in read.blocks] == ["impact_p03_1", "impact_p03_2", "sine_low_029.297"]
    first, sine = read.blocks[0], read.blocks[2]
    assert (first.test, first.rate_hz, first.drive_point, first.units) == ("impact", 2000.0, 3, ("V",) * 4)
    assert (sine.test, sine.level, sine.frequency_hz, sine.rate_hz) == ("sine", "low", 29.297, 1000.0)
    assert first.samples.dtype == np.int16
    assert first.samples[:, 100].tolist() == [9001, 0, 1, 1]
    np.testing.assert_array_equal(first.scale, np.full(4, 10 / 32768))


def test_version_2_reads_for_ever() -> None:
    read = read_campaign(DATA / "campaign_v2.h5")
    assert [b.samples.dtype.name for b in read.blocks] == ["int32", "float32", "float64", "int16"]
    first, last = read.blocks[0], read.blocks[3]
    assert (first.requested_rate_hz, first.actual_rate_hz, first.rate_hz) == (2000.0, 2048.0, 2048.0)
    assert (first.first_sample, first.overload) == (4096, (False, False, False, True))
    assert first.samples[:, 102].tolist() == [847616, 19712, 78336, 196864]
    assert (last.level, last.frequency_hz, last.units) == ("high", 30 / 1.024, ("mV",) * 4)
    assert read.provenance == {"seed": "5", "code": "modallab 0.1.0"}
    (frf,) = read.frfs
    assert (frf.quantity, frf.outputs, frf.input_points, frf.averages) == (
        "receptance",
        ("a01", "a02", "a03"),
        (3,),
        (5,),
    )
    assert frf.values.shape == (3, 1, 32)
    assert frf.coherence is not None
    assert read.rig.name == "elastic link"


def test_the_real_hits_are_read_with_their_rig_inside() -> None:
    read = read_campaign(DATA / "hammer_5hits.h5")
    assert len(read.blocks) == 5
    assert {(b.rate_hz, b.n_samples, b.units) for b in read.blocks} == {(25600.0, 25600, ("N", "m/s^2"))}
    peaks = [float((b.samples[0] * b.scale[0]).max()) for b in read.blocks]
    assert peaks == pytest.approx([68.64, 83.67, 85.41, 88.88, 76.48], abs=0.01)
    assert read.rig.model == "unknown"


@pytest.mark.parametrize("dtype", [np.int16, np.int32, np.float32, np.float64])
def test_every_device_type_comes_back_to_the_last_bit(tmp_path: Path, dtype: type) -> None:
    original = block(
        RIG,
        (100 * hit(4)).astype(dtype),
        name="sine_high_4.883 a",
        test="sine",
        order=7,
        level="höch",
        drive_point=2,
        frequency_hz=5 / 1.024,
        first_sample=2**40,
        requested_rate_hz=1000.0,
        actual_rate_hz=1651.6129,
        overload=(True, False, False, False),
        units=("mV", "g", "V", "mm/s^2"),
    )
    write_campaign(campaign(RIG, original, provenance={"seed": "1", "unit": "m/s²"}), tmp_path / "c.h5")
    read = read_campaign(tmp_path / "c.h5")
    assert_same(original, read.blocks[0])
    assert read.rig == RIG
    assert read.provenance == {"seed": "1", "unit": "m/s²"}


def test_frfs_come_back(tmp_path: Path) -> None:
    values = receptances()[:, None, :]
    frf = Frf(
        frequency_hz=np.arange(1.0, 65.0),
        values=values,
        quantity="mobility",
        outputs=("a01", "a02", "a03"),
        output_points=(1, None, 3),
        input_points=(None,),
        coherence=np.full(values.shape, 0.9),
        variance=np.abs(values),
        averages=(5,),
        damping_shift=-3.0,
    )
    write_campaign(Campaign(RIG, (), (frf,)), tmp_path / "c.h5")
    assert_same(frf, read_campaign(tmp_path / "c.h5").frfs[0])


def test_the_rig_is_the_one_given_else_the_one_inside_else_the_one_beside(tmp_path: Path) -> None:
    write_campaign(campaign(RIG), tmp_path / "c.h5")
    believed = RIG.model_copy(update={"name": "another belief"})
    assert read_campaign(tmp_path / "c.h5", believed).rig.name == "another belief"
    assert read_campaign(tmp_path / "c.h5").rig.name == "elastic link"
    lone = tmp_path / "lone.h5"
    lone.write_bytes((DATA / "campaign_v1" / "campaign.h5").read_bytes())
    assert "no rig: none in the file, and no rig.yaml beside it" in rejected(RigError, lone)
    write_rig(believed, tmp_path / "rig.yaml")
    assert read_campaign(lone).rig.name == "another belief"


def test_every_practice_campaign_passes_the_checks(practice: Path) -> None:
    for folder in sorted(practice.glob("practice_*"))[::30]:
        assert len(read_campaign(folder).blocks) == 66


def test_a_newer_version_is_rejected_by_name(tmp_path: Path) -> None:
    write_campaign(campaign(RIG), tmp_path / "c.h5")
    with h5py.File(tmp_path / "c.h5", "r+") as target:
        target.attrs["format_version"] = 3
    message = rejected(FormatError, tmp_path / "c.h5")
    assert "format version 3; this modallab reads up to 2" in message
    assert "update modallab" in message


def test_foreign_hdf5_is_rejected_by_name(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "c.h5", "w") as target:
        target["x"] = np.arange(3)
    assert "is HDF5, but no campaign" in rejected(FormatError, tmp_path / "c.h5")


def test_what_is_no_file_is_rejected_by_name(tmp_path: Path) -> None:
    (tmp_path / "empty.h5").touch()
    (tmp_path / "text.h5").write_text("time,force\n")
    assert "is empty" in rejected(FormatError, tmp_path / "empty.h5")
    assert "is no HDF5 file" in rejected(FormatError, tmp_path / "text.h5")
    assert "No such file" in rejected(FormatError, tmp_path / "none.h5")
    assert "is a folder without campaign.h5" in rejected(FormatError, tmp_path)


@pytest.mark.parametrize("name", ["campaign_v1/campaign.h5", "campaign_v2.h5"])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.999])
def test_a_file_cut_off_says_how_much_of_it_is_there(tmp_path: Path, name: str, share: float) -> None:
    raw = (DATA / name).read_bytes()
    (tmp_path / "c.h5").write_bytes(raw[: int(share * len(raw))])
    message = rejected(FormatError, tmp_path / "c.h5", RIG)
    assert "is cut off" in message or "is damaged" in message


def test_a_changed_record_does_not_agree_with_its_checksum(tmp_path: Path) -> None:
    write_campaign(campaign(RIG), tmp_path / "c.h5")
    with h5py.File(tmp_path / "c.h5", "r+") as target:
        target["records/hit_1"][2, 17] += 1
    assert "record hit_1: does not agree with its checksum" in rejected(FormatError, tmp_path / "c.h5")


def test_a_lost_piece_of_a_record_is_not_read_as_zeros(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "c.h5", "w") as target:
        target.attrs["volts_per_count"] = 3e-4
        record = target.create_dataset("hit", (4, 256), np.int16, chunks=(4, 128))
        record[:, :128] = counts(RIG)[:, :128]
        for name, value in (("order", 0), ("test", "impact"), ("sample_rate_hz", 2000.0)):
            record.attrs[name] = value
    assert "1 of 2 pieces of its samples are lost" in rejected(FormatError, tmp_path / "c.h5", RIG)


@pytest.mark.parametrize("name", ["order", "test", "sample_rate_hz"])
def test_a_missing_attribute_is_named(tmp_path: Path, name: str) -> None:
    target = tmp_path / "c.h5"
    target.write_bytes((DATA / "campaign_v1" / "campaign.h5").read_bytes())
    with h5py.File(target, "r+") as source:
        del source["impact_p03_2"].attrs[name]
    assert f"record impact_p03_2: has no attribute '{name}'" in rejected(FormatError, target, RIG)


def test_channels_that_are_not_those_of_the_rig_are_named(tmp_path: Path) -> None:
    write_campaign(campaign(RIG), tmp_path / "c.h5")
    message = rejected(DataError, tmp_path / "c.h5", beam_rig(5))
    assert "record hit_1: 4 channels where the rig has 6; no channel a04, a05" in message
    message = rejected(DataError, DATA / "campaign_v1", plain_rig("a01"))
    assert "4 channels where the rig has 2" in message


def test_all_bad_records_stand_in_one_message(tmp_path: Path) -> None:
    spoilt, nan = hit(4), hit(4)
    spoilt[0, 3], nan[3, 9] = np.inf, np.nan
    blocks = (block(RIG, spoilt), block(RIG, nan, name="hit_2"), block(RIG, counts(RIG), name="hit_3"))
    write_campaign(campaign(RIG, *blocks), tmp_path / "c.h5")
    message = rejected(DataError, tmp_path / "c.h5")
    assert "2 problems" in message
    assert "record hit_1: channel force: 1 of 256 samples are NaN or infinite, the first is sample 3" in message
    assert "record hit_2: channel a03: 1 of 256 samples are NaN or infinite, the first is sample 9" in message
    assert len(read_campaign(tmp_path / "c.h5", check=False).blocks) == 3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"units": ("Pa", "V", "V", "V")}, "channel force: unit 'Pa' is no unit of force"),
        ({"scale": np.array([1.0, 0.0, 1.0, 1.0])}, "channel a01: the scale is 0"),
        ({"scale": np.ones(3)}, "3 scales"),
        ({"rate_hz": 0.0}, "the sampling rate is 0.0 Hz"),
        ({"channels": ("force", "a02", "a01", "a03")}, "channels in the order force, a02, a01, a03"),
        ({"name": "a/b"}, "a record is named 'a/b'"),
    ],
)
def test_parts_that_do_not_belong_together_are_not_written(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    with pytest.raises(DataError) as caught:
        write_campaign(campaign(RIG, block(RIG, counts(RIG), **change)), tmp_path / "c.h5")
    assert words in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_two_records_of_one_name_are_not_written(tmp_path: Path) -> None:
    twice = (block(RIG, counts(RIG)), block(RIG, counts(RIG)))
    with pytest.raises(DataError, match="2 records are named 'hit_1'"):
        write_campaign(campaign(RIG, *twice), tmp_path / "c.h5")


def test_writing_that_fails_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "c.h5"
    write_campaign(campaign(RIG), target)
    before = target.read_bytes()

    def break_off(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(h5py.Group, "create_dataset", break_off)
    frf = Frf(np.arange(1.0, 65.0), receptances()[:, None, :], "mobility", ("a01", "a02", "a03"), (1, 2, 3), (1,))
    with pytest.raises(KeyboardInterrupt):
        write_campaign(replace(campaign(RIG), frfs=(frf,)), target)
    assert target.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["c.h5"]


def test_a_full_disk_is_reported_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: Path, content: memoryview) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(DiskFullError, match="the disk is full; nothing was written"):
        write_campaign(campaign(RIG), tmp_path / "c.h5")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_missing_or_a_file_of_the_same_name_is_reported(tmp_path: Path) -> None:
    (tmp_path / "folder.h5").mkdir()
    for target, said in ((tmp_path / "nowhere" / "c.h5", "cannot be written"), (tmp_path / "folder.h5", "is a folder")):
        with pytest.raises(StorageError, match=said):
            write_campaign(campaign(RIG), target)
    assert [file.name for file in tmp_path.iterdir()] == ["folder.h5"]


def test_the_same_campaign_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.h5", "b.h5"):
        write_campaign(campaign(RIG, provenance={"seed": "3"}), tmp_path / name)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_a_record_longer_than_one_piece_comes_back(tmp_path: Path) -> None:
    samples = np.random.default_rng(1).normal(size=(4, 70_000))
    original = block(RIG, samples)
    assert samples.nbytes > 2 * 2**20
    write_campaign(campaign(RIG, original), tmp_path / "c.h5")
    assert_same(original, read_campaign(tmp_path / "c.h5").blocks[0])
