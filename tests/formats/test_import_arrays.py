"""MATLAB, WAV and netCDF4 files made here are read to the last bit, or rejected by name."""

import struct
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from exchange_records import RATE_HZ, hit, times
from exchange_rigs import beam_rig
from scipy import io
from scipy.io import wavfile

from modallab.cli import main
from modallab.core.errors import DataError, FormatError
from modallab.formats import import_sources
from modallab.formats.arrays.mat import draft_mat
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.options import ImportOptions
from modallab.formats.rig.rig_file import write_rig

RIG = beam_rig()
NAMES = ("force", "a01", "a02", "a03")
LINES = np.arange(1.0, 41.0)


def save_7_3(path: Path, **variables: Any) -> Path:
    """As MATLAB does: HDF5 behind a head of 512 bytes, columns first."""
    with h5py.File(path, "w", userblock_size=512) as target:
        for name, value in variables.items():
            value = np.atleast_2d(value).T if np.ndim(value) < 2 else np.asarray(value).T
            if np.iscomplexobj(value):
                pairs = np.zeros(value.shape, [("real", "f8"), ("imag", "f8")])
                pairs["real"], pairs["imag"] = value.real, value.imag
                value = pairs
            target.create_dataset(name, data=value).attrs["MATLAB_class"] = np.bytes_("double")
        target.create_dataset("remark", data=np.zeros((3, 1), np.uint16)).attrs["MATLAB_class"] = np.bytes_("char")
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116))
    return path


def save_5(path: Path, **variables: Any) -> Path:
    io.savemat(path, {**variables, "remark": "any"})
    return path


def mobilities() -> np.ndarray:
    poles = np.array([-1.0 + 60j, -2.0 + 150j, -1.5 + 200j])
    s = 2j * np.pi * LINES
    return np.array([[s / (s - p) + s / (s - p.conjugate())] for p in poles])


def save_4(path: Path, **variables: Any) -> Path:
    io.savemat(path, variables, format="4")
    return path


@pytest.mark.parametrize("save", [save_4, save_5, save_7_3])
def test_channels_are_variables_of_their_names(tmp_path: Path, save: Any) -> None:
    rows = hit(4)
    path = save(tmp_path / "hit.mat", Force=rows[0], a01=rows[1], a02=rows[2], a03=rows[3], t=times())
    (block,) = import_sources([path], RIG, ImportOptions(drive_point=2)).blocks
    np.testing.assert_array_equal(block.samples, rows)
    assert (block.rate_hz, block.channels, block.drive_point) == (RATE_HZ, NAMES, 2)


@pytest.mark.parametrize("save", [save_5, save_7_3])
def test_one_array_holds_all_channels_either_way_round(tmp_path: Path, save: Any) -> None:
    rows = hit(4)
    for values in (rows, rows.T):
        (block,) = import_sources([save(tmp_path / "hit.mat", data=values, fs=RATE_HZ)], RIG).blocks
        np.testing.assert_array_equal(block.samples, rows)


def test_arrays_of_other_names_and_columns_are_named_at_the_terminal(tmp_path: Path) -> None:
    rows = hit(4)
    path = save_5(tmp_path / "hit.mat", run={"F": rows[0], "acc": rows[1:].T}, Fs=RATE_HZ)
    write_rig(RIG, tmp_path / "rig.yaml")
    out = tmp_path / "campaign.h5"
    variables = ["force=run.F", *(f"a0{k}=run.acc:{k}" for k in (1, 2, 3))]
    command = ["import", str(path), "--rig", str(tmp_path / "rig.yaml"), "--out", str(out), "--variable"]
    assert main([*command, *variables]) == 0
    np.testing.assert_array_equal(read_campaign(out).blocks[0].samples, rows)
    assert main([*command, "force"]) == 2


@pytest.mark.parametrize("save", [save_5, save_7_3])
def test_complex_frfs_come_with_their_lines_and_coherence(tmp_path: Path, save: Any) -> None:
    values = mobilities()
    path = save(tmp_path / "frf.mat", H=values.transpose(2, 0, 1)[..., 0], f=LINES, coh=np.full((40, 3), 0.9))
    (frf,) = import_sources([path], RIG, ImportOptions(drive_point=2, window_s=0.5)).frfs
    np.testing.assert_array_equal(frf.values, values)
    np.testing.assert_array_equal(frf.frequency_hz, LINES)
    assert (frf.quantity, frf.input_points, frf.damping_shift) == ("inertance", (2,), 2.0)
    assert frf.coherence is not None
    assert np.all(frf.coherence == 0.9)


@pytest.mark.parametrize("save", [save_5, save_7_3])
def test_an_axis_of_one_element_is_not_lost(tmp_path: Path, save: Any) -> None:
    values = mobilities()
    path = save(tmp_path / "frf.mat", H=values.transpose(1, 0, 2), f=LINES)
    with pytest.raises(DataError, match=r"FRFs of shape \(1, 3, 40\) are 3 outputs of one input, or one output of 3"):
        draft_mat(path, ImportOptions())
    assert len(draft_mat(path, ImportOptions(drive_point=2)).responses) == 3
    (frf,) = import_sources([path], RIG, ImportOptions(drive_point=2)).frfs
    np.testing.assert_array_equal(frf.values, values)
    one = RIG.of_outputs(["a01"])
    (frf,) = import_sources([path], one, ImportOptions()).frfs
    np.testing.assert_array_equal(frf.values, values.transpose(1, 0, 2))


def test_the_unit_beside_times_and_frequencies_is_used(tmp_path: Path) -> None:
    rows, values = hit(4), mobilities()
    channels = {name: {"data": row} for name, row in zip(NAMES, rows, strict=True)}
    path = save_5(tmp_path / "hit.mat", time=times() * 1e3, time_unit="ms", **channels)
    assert import_sources([path], RIG).blocks[0].rate_hz == pytest.approx(RATE_HZ)
    path = save_5(tmp_path / "frf.mat", H=values, frequency=LINES / 1e3, frequency_unit="kHz")
    np.testing.assert_allclose(import_sources([path], RIG).frfs[0].frequency_hz, LINES)


def test_times_are_dates_or_clock_texts_or_in_the_unit_that_ends_their_name(tmp_path: Path) -> None:
    rows = hit(4)
    ticks = np.arange(rows.shape[1]) * 500
    dates = np.datetime64("2026-11-28T23:59:59.5", "us") + ticks
    texts = np.array([str(date) for date in dates])
    for axis, said in ((dates, "time"), (texts, "time"), (ticks, "time_us")):
        np.savez(tmp_path / "a.npz", **dict(zip([*NAMES, said], [*rows, axis], strict=True)))
        (block,) = import_sources([tmp_path / "a.npz"], RIG, ImportOptions(variables=(("time", said),))).blocks
        assert block.rate_hz == pytest.approx(2000.0, rel=1e-9)


def test_times_in_single_precision_are_as_even_as_their_digits(tmp_path: Path) -> None:
    rows = hit(4)
    path = save_5(tmp_path / "hit.mat", time=(100 + times()).astype("f4"), **dict(zip(NAMES, rows, strict=True)))
    assert import_sources([path], RIG).blocks[0].rate_hz == pytest.approx(RATE_HZ, rel=1e-6)


def test_fields_of_a_compound_dataset_are_channels(tmp_path: Path) -> None:
    rows = hit(4)
    table = np.zeros(rows.shape[1], [(name, "f8") for name in ("time", *NAMES)])
    for name, row in zip(("time", *NAMES), (times(), *rows), strict=True):
        table[name] = row
    with h5py.File(tmp_path / "hit.h5", "w") as file:
        file["records/table"] = table
    np.testing.assert_array_equal(import_sources([tmp_path / "hit.h5"], RIG).blocks[0].samples, rows)


def test_a_sound_file_in_a_telephone_code_is_named_as_such(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "hit.wav", int(RATE_HZ), (hit(4) * 10).astype(np.int16).T)
    data = bytearray((tmp_path / "hit.wav").read_bytes())
    data[20:22] = (6).to_bytes(2, "little")
    (tmp_path / "hit.wav").write_bytes(data)
    with pytest.raises(DataError, match="holds samples in a code that is not linear: ALAW"):
        import_sources([tmp_path / "hit.wav"], RIG)


@pytest.mark.parametrize(("kind", "full_scale"), [(np.float32, 1.0), (np.int16, 2.0**15), (np.int32, 2.0**31)])
def test_sound_files_hold_the_channels_in_rig_order(tmp_path: Path, kind: Any, full_scale: float) -> None:
    rows = (hit(4) / 100 * full_scale).astype(kind)
    wavfile.write(tmp_path / "hit.wav", int(RATE_HZ), rows.T)
    campaign = import_sources([tmp_path / "hit.wav"], RIG, ImportOptions(volts=True))
    np.testing.assert_array_equal(campaign.blocks[0].samples, rows / full_scale)
    assert campaign.blocks[0].units == ("V",) * 4
    assert ("full scale" in campaign.provenance.get("notes", "")) == (full_scale > 1)


def test_a_sound_file_that_was_streamed_reaches_to_its_end(tmp_path: Path) -> None:
    rows = hit(4).astype(np.float32)
    wavfile.write(tmp_path / "hit.wav", int(RATE_HZ), rows.T)
    raw = (tmp_path / "hit.wav").read_bytes()
    place = raw.index(b"data") + 4
    (tmp_path / "hit.wav").write_bytes(raw[:4] + b"\xff" * 4 + raw[8:place] + b"\xff" * 4 + raw[place + 4 :])
    np.testing.assert_array_equal(import_sources([tmp_path / "hit.wav"], RIG).blocks[0].samples, rows)


def test_a_sound_file_of_64_bit_lengths_is_one(tmp_path: Path) -> None:
    rows = hit(4).astype(np.float32)
    wavfile.write(tmp_path / "hit.wav", int(RATE_HZ), rows.T)
    raw = (tmp_path / "hit.wav").read_bytes()
    place = raw.index(b"data")
    lengths = struct.pack("<4sIQQQI", b"ds64", 28, len(raw) + 28, rows.nbytes, rows.shape[1], 0)
    body = raw[8:12] + lengths + raw[12 : place + 4] + b"\xff" * 4 + raw[place + 8 :] + b"LIST\4\0\0\0INFO"
    (tmp_path / "hit.wav").write_bytes(b"RF64" + b"\xff" * 4 + body)
    np.testing.assert_array_equal(import_sources([tmp_path / "hit.wav"], RIG).blocks[0].samples, rows)


def test_a_sound_file_of_other_channels_than_the_rigs_says_how_many(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "hit.wav", int(RATE_HZ), hit(3).T)
    with pytest.raises(DataError, match="holds 3 channels, and the rig names 4: force, a01, a02, a03"):
        import_sources([tmp_path / "hit.wav"], RIG)


def test_what_rattlesnake_streams_is_a_record(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.nc4", "w") as target:
        target.create_dataset("time_data", data=hit(4))
        target.attrs["sample_rate"] = np.int64(RATE_HZ)
    (block,) = import_sources([tmp_path / "run.nc4"], RIG).blocks
    np.testing.assert_array_equal(block.samples, hit(4))
    assert block.rate_hz == RATE_HZ


@pytest.mark.parametrize(
    ("variables", "words"),
    [
        ({"force": hit(4)[0], "fs": RATE_HZ}, "no array for channel a01, a02, a03; there are force"),
        ({"data": hit(4)}, "says neither times nor a rate"),
        (
            dict.fromkeys(NAMES, np.column_stack([times(), hit(1)[0]])),
            "force is an array of 256x2",
        ),
        ({"H": mobilities()[:, 0, :30], "f": LINES}, "are none of 3 outputs at 40 lines"),
    ],
)
def test_what_is_missing_is_named(tmp_path: Path, variables: dict[str, Any], words: str) -> None:
    with pytest.raises(DataError, match=words):
        import_sources([save_5(tmp_path / "any.mat", **variables)], RIG)


def test_damaged_files_are_rejected(tmp_path: Path) -> None:
    whole = save_5(tmp_path / "whole.mat", data=hit(4), fs=RATE_HZ).read_bytes()
    (tmp_path / "cut.mat").write_bytes(whole[: len(whole) // 2])
    newer = save_7_3(tmp_path / "newer.mat", data=hit(4), fs=RATE_HZ).read_bytes()
    (tmp_path / "cut73.mat").write_bytes(newer[: len(newer) // 2])
    wavfile.write(tmp_path / "whole.wav", 2000, np.zeros((100, 4), np.int16))
    (tmp_path / "cut.wav").write_bytes((tmp_path / "whole.wav").read_bytes()[:400])
    for name in ("cut.mat", "cut73.mat", "cut.wav"):
        with pytest.raises(FormatError, match="is no whole"):
            import_sources([tmp_path / name], RIG)
