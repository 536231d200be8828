"""A unit at the end of a name counts in every container; times without one are seconds only where that can be."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from exchange_records import RATE_HZ, hit, times
from exchange_rigs import beam_rig
from tdms_files import channel, segment

from modallab.core.block import Campaign
from modallab.core.errors import DataError, FormatError
from modallab.formats import import_sources
from modallab.formats.options import ImportOptions
from modallab.signals.signals import to_signals

RIG = beam_rig()
NAMES = tuple(c.name for c in RIG.channels)
ROWS = hit(4)
WRITTEN = {f"{NAMES[0]} (kN)": ROWS[0] / 1e3, **dict(zip(NAMES[1:], ROWS[1:], strict=True))}


def as_tdms(folder: Path) -> Path:
    objects = [channel(f"/'hit'/'{name}'", row, {"wf_increment": 1 / RATE_HZ}) for name, row in WRITTEN.items()]
    path = folder / "hit.tdms"
    path.write_bytes(segment(objects, b"".join(row.tobytes() for row in WRITTEN.values())))
    return path


def as_npz(folder: Path) -> Path:
    np.savez(folder / "hit.npz", **{"time [ms]": 1e3 * times(), **WRITTEN})
    return folder / "hit.npz"


def as_hdf5(folder: Path) -> Path:
    with h5py.File(folder / "hit.h5", "w") as file:
        for name, row in WRITTEN.items():
            file[f"hit/{name}"] = row
        file["hit"].attrs["fs"] = RATE_HZ
    return folder / "hit.h5"


def as_lvm(folder: Path) -> Path:
    lines = ["LabVIEW Measurement\t", "Separator\tTab", "X_Columns\tNo", "***End_of_Header***\t", ""]
    lines += [f"Channels\t{len(WRITTEN)}", "\t".join(["Delta_X", *(f"{1 / RATE_HZ}" for _ in WRITTEN)])]
    lines += ["***End_of_Header***", "\t".join(["X_Value", *WRITTEN, "Comment"])]
    lines += ["\t".join(["", *(repr(float(v)) for v in row)]) for row in zip(*WRITTEN.values(), strict=True)]
    (folder / "hit.lvm").write_text("\n".join(lines) + "\n", encoding="ascii")
    return folder / "hit.lvm"


def as_csv(folder: Path) -> Path:
    table = np.column_stack([times(), *WRITTEN.values()])
    np.savetxt(folder / "hit.csv", table, delimiter=",", header=",".join(["time", *WRITTEN]), comments="")
    return folder / "hit.csv"


def force_of(campaign: Campaign) -> np.ndarray:
    (block,) = campaign.blocks
    assert block.rate_hz == RATE_HZ
    return to_signals(block, campaign.rig).force


@pytest.mark.parametrize("write", [as_tdms, as_npz, as_hdf5, as_lvm, as_csv])
def test_a_unit_in_a_name_counts(tmp_path: Path, write) -> None:
    campaign = import_sources([write(tmp_path)], RIG)
    np.testing.assert_allclose(force_of(campaign), ROWS[0], rtol=1e-9, atol=1e-12)


def test_a_column_has_the_unit_of_its_array(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "hit.h5", "w") as file:
        file["data/all"] = ROWS.T / 1e3
        file["data/all"].attrs["unit"] = [b"kN", *(b"km/s^2" for _ in NAMES[1:])]
        file["data/fs"] = RATE_HZ
    said = tuple((name, f"/data/all:{k}") for k, name in enumerate(NAMES, start=1))
    options = ImportOptions(variables=said)
    with pytest.raises(DataError, match="km/s"):
        import_sources([tmp_path / "hit.h5"], RIG, options)
    with h5py.File(tmp_path / "hit.h5", "a") as file:
        file["data/all"].attrs["unit"] = [b"kN", *(b"m/s^2" for _ in NAMES[1:])]
    force = force_of(import_sources([tmp_path / "hit.h5"], RIG, options))
    np.testing.assert_allclose(force, ROWS[0], rtol=1e-9)


def test_names_that_differ_in_their_unit_alone_stay_apart(tmp_path: Path) -> None:
    rows = dict(zip(NAMES, ROWS, strict=True)) | {f"{NAMES[1]} (mV)": ROWS[1] + 1}
    objects = [channel(f"/'hit'/'{name}'", row, {"wf_increment": 1 / RATE_HZ}) for name, row in rows.items()]
    (tmp_path / "hit.tdms").write_bytes(segment(objects, b"".join(row.tobytes() for row in rows.values())))
    signals = to_signals(import_sources([tmp_path / "hit.tdms"], RIG).blocks[0], RIG)
    np.testing.assert_array_equal(signals.responses[0], ROWS[1])


@pytest.mark.parametrize("factor", [1e9, 1e6, 1e3, 1 / 86400 / 1e3], ids=["ns", "us", "ms", "days"])
def test_times_without_a_unit_are_seconds_only_where_a_bench_records_so(tmp_path: Path, factor: float) -> None:
    rows = np.column_stack([1e-3 * times() if factor < 1 else times(), ROWS.T])
    rows[:, 0] *= factor
    np.savetxt(tmp_path / "hit.csv", rows, delimiter=",", header=",".join(["time", *NAMES]), comments="", fmt="%.15g")
    np.savez(tmp_path / "hit.npz", time=rows[:, 0], **dict(zip(NAMES, ROWS, strict=True)))
    for name in ("hit.csv", "hit.npz"):
        with pytest.raises(DataError, match="taken as s"):
            import_sources([tmp_path / name], RIG)


@pytest.mark.parametrize("form", ["0 days 00:00:{:09.6f}", "23:59:{:09.6f}"])
def test_durations_and_clocks_are_times(tmp_path: Path, form: str) -> None:
    cells = [form.format(t) for t in times()]
    lines = [",".join([cell, *(repr(float(v)) for v in row)]) for cell, row in zip(cells, ROWS.T, strict=True)]
    (tmp_path / "hit.csv").write_text("\n".join([",".join(["", *NAMES]), *lines, ""]), encoding="ascii")
    np.testing.assert_array_equal(force_of(import_sources([tmp_path / "hit.csv"], RIG)), ROWS[0])


@pytest.mark.parametrize(
    ("head", "what"), [(b"\x1f\x8b\x08", "gzip"), (b"PAR1", "Parquet"), (b"PK\x03\x04", "workbook")]
)
def test_files_of_other_kinds_are_called_by_what_they_are(tmp_path: Path, head: bytes, what: str) -> None:
    (tmp_path / "hit.data").write_bytes(head + bytes(range(64)))
    with pytest.raises(FormatError, match=what):
        import_sources([tmp_path / "hit.data"], RIG)


def test_objects_of_matlab_are_named(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "hit.mat", "w", userblock_size=512) as file:
        file["hit"] = np.array([[3707764736, 2, 1, 1, 1, 1]], "u4")
        file["hit"].attrs["MATLAB_class"] = np.bytes_("timetable")
        file["hit"].attrs["MATLAB_object_decode"] = np.int32(3)
    with (tmp_path / "hit.mat").open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    with pytest.raises(DataError, match=r"hit \(timetable\)"):
        import_sources([tmp_path / "hit.mat"], RIG)
