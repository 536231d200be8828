"""NPY files: rows of times, force and responses; anything else is rejected with what to do."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exchange_records import RATE_HZ, hit, times
from exchange_rigs import beam_rig, plain_rig

from modallab.core.errors import DataError, FormatError, ModallabError
from modallab.formats.importer import import_sources
from modallab.formats.options import ImportOptions

RIG = beam_rig()


def save(folder: Path, array: Any, name: str = "hit_1.npy", **options: Any) -> Path:
    np.save(folder / name, array, **options)
    return folder / name


def rejected(kind: type[ModallabError], path: Path, options: ImportOptions | None = None) -> str:
    with pytest.raises(kind) as caught:
        import_sources([path], RIG, options)
    assert str(path) in str(caught.value)
    assert caught.value.remedy
    return str(caught.value)


@pytest.mark.parametrize("dtype", ["<f8", "<f4", ">f8"])
def test_times_and_channels_in_rig_order(tmp_path: Path, dtype: str) -> None:
    rows = np.vstack([times(), hit(4)]).astype(dtype)
    (read,) = import_sources([save(tmp_path, rows)], RIG).blocks
    assert (read.name, read.rate_hz, read.test, read.drive_point) == ("hit_1", RATE_HZ, "impact", None)
    assert (read.units, read.channels) == (("N", "m/s^2", "m/s^2", "m/s^2"), ("force", "a01", "a02", "a03"))
    assert read.samples.dtype == np.dtype(dtype).newbyteorder("=")
    np.testing.assert_array_equal(read.samples, rows[1:])


def test_without_times_the_rate_must_be_given(tmp_path: Path) -> None:
    path = save(tmp_path, hit(4))
    assert "has 4 rows, as many as the rig has channels: no times, and no rate is given" in rejected(DataError, path)
    options = ImportOptions(rate_hz=1651.6129, test="sine", drive_point=2, volts=True)
    (read,) = import_sources([path], RIG, options).blocks
    assert (read.rate_hz, read.test, read.drive_point, read.units) == (1651.6129, "sine", 2, ("V",) * 4)


def test_a_rate_that_is_not_that_of_the_times_is_rejected(tmp_path: Path) -> None:
    path = save(tmp_path, np.vstack([times(), hit(4)]))
    assert "the file says 2000 Hz, --rate says 1000 Hz" in rejected(DataError, path, ImportOptions(rate_hz=1000.0))


def test_the_drive_point_must_be_on_the_rig(tmp_path: Path) -> None:
    path = save(tmp_path, np.vstack([times(), hit(4)]))
    with pytest.raises(DataError, match="the drive point is 9; the rig has 1, 2, 3"):
        import_sources([path], RIG, ImportOptions(drive_point=9))


def lost(rows: np.ndarray) -> np.ndarray:
    return np.delete(rows, 100, axis=1)


def spoilt(row: int, value: Any, at: Any = slice(None)) -> np.ndarray:
    rows = np.vstack([times(), hit(4)])
    rows[row, at] = value
    return rows


GOOD = np.vstack([times(), hit(4)])

CASES: list[tuple[str, Any, str]] = [
    ("NaN", spoilt(3, np.nan, 7), "channel a02: 1 of 256 samples are NaN or infinite, the first is sample 7"),
    ("infinity", spoilt(1, np.inf, 7), "channel force: 1 of 256 samples are NaN or infinite"),
    ("a dead force", spoilt(1, 0.0), "channel force is dead: all 256 samples are 0"),
    ("all zeros", np.vstack([times(), np.zeros((4, 256))]), "every channel is zero (force, a01, a02, a03)"),
    ("transposed", GOOD.T, "holds an array of shape (256, 5): more rows than columns, it looks transposed"),
    ("a lost sample", lost(GOOD), "row 0 (times): the time axis is uneven"),
    ("descending times", GOOD[:, ::-1], "row 0 (times): the time axis descends"),
    ("NaN in times", spoilt(0, np.nan, 5), "row 0 (times): the time axis holds nan at place 5"),
    ("too few channels", GOOD[:3], "has 3 rows; the rig has 4 channels (force, a01, a02, a03), so 5 rows with times"),
    ("one row", GOOD[1], "holds an array of shape (256,)"),
    ("nothing", np.zeros((5, 0)), "holds an array of shape (5, 0)"),
    ("whole numbers", np.zeros((5, 256), np.int16), "holds whole numbers (int16), whose scale is not known"),
    ("complex numbers", GOOD.astype(complex), "holds values of type complex128"),
    ("text", GOOD.astype(str), "holds values of type <U32"),
    ("half precision", GOOD.astype(np.float16), "holds values of type float16"),
]


@pytest.mark.parametrize(("array", "words"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_bad_arrays_are_rejected_by_name(tmp_path: Path, array: Any, words: str) -> None:
    assert words in rejected(DataError, save(tmp_path, array))


def test_objects_are_never_unpickled(tmp_path: Path) -> None:
    path = save(tmp_path, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    assert "is no whole NPY file" in rejected(FormatError, path)


@pytest.mark.parametrize("keep", [7, 60, 1000])
def test_a_file_cut_off_is_reported(tmp_path: Path, keep: int) -> None:
    path = save(tmp_path, GOOD)
    path.write_bytes(path.read_bytes()[:keep])
    assert "is no whole NPY file" in rejected(FormatError, path)


def test_bytes_too_many_are_reported(tmp_path: Path) -> None:
    path = save(tmp_path, GOOD)
    path.write_bytes(path.read_bytes() + b"\0" * 8)
    assert "bytes where its header says" in rejected(FormatError, path)


def test_copied_channels_are_noted_not_rejected(tmp_path: Path) -> None:
    path = save(tmp_path, spoilt(3, GOOD[2]))
    assert "hit_1: channels a01 and a02 agree in every bit" in import_sources([path], RIG).provenance["notes"]


def test_one_force_and_one_sensor_of_an_unknown_structure(tmp_path: Path) -> None:
    (read,) = import_sources([save(tmp_path, GOOD[:3])], plain_rig()).blocks
    assert read.channels == ("force", "acceleration")
