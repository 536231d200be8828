"""What a file itself says of its columns is believed before the order of the rig."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from exchange_records import RATE_HZ, hit, times
from exchange_rigs import beam_rig
from scipy import io

from modallab.core.errors import DataError
from modallab.formats import import_sources
from modallab.formats.arrays.mat import draft_mat
from modallab.formats.options import ImportOptions

RIG = beam_rig()
NAMES = ("force", "a01", "a02", "a03")
ORDER = (2, 0, 3, 1)
"""The rows of a hit as a file with an order of its own holds them."""


def cell(names: Any) -> np.ndarray:
    held = np.empty((1, len(names)), object)
    held[0] = list(names)
    return held


def named(order: tuple[int, ...] = ORDER) -> list[str]:
    return [NAMES[k] for k in order]


def rattlesnake(path: Path, nodes: list[str], units: list[str]) -> None:
    with h5py.File(path, "w") as target:
        target.create_dataset("time_data", data=hit(4)[list(ORDER)])
        target.attrs["sample_rate"] = np.int64(RATE_HZ)
        text = h5py.string_dtype()
        for key, values in {"node_number": nodes, "node_direction": ["Z+"] * 4, "unit": units}.items():
            target.create_dataset(f"channels/{key}", data=np.array(values, object), dtype=text)


def write_matlab(path: Path) -> None:
    io.savemat(path, {"x": hit(4)[list(ORDER)].T, "fs": RATE_HZ, "chNames": cell(named())})


def write_simulink(path: Path) -> None:
    signals = np.zeros((1, 4), dtype=[("values", "O"), ("label", "O")])
    for k, row in enumerate(ORDER):
        signals[0, k] = (hit(4)[row], NAMES[row])
    io.savemat(path, {"Scope": {"time": times()[:, None], "signals": signals}})


def write_npy(path: Path) -> None:
    fields = np.zeros(times().size, [(name, "f8") for name in ("a02", "time", "force", "a03", "a01")])
    for name, row in (*zip(NAMES, hit(4), strict=True), ("time", times())):
        fields[name] = row
    np.save(path, fields)


def write_logger(path: Path) -> None:
    """Campbell's TOA5: station, names, units, processing."""
    heads = [
        '"TOA5","CR6","1","2","3","4"',
        '"TIMESTAMP","RECORD","a02","force","a03","a01"',
        '"TS","RN","m/s^2","N","m/s^2","m/s^2"',
        '"","","Smp","Smp","Smp","Smp"',
    ]
    rows = zip(times(), hit(4)[list(ORDER)].T, strict=True)
    body = [f'"2026-11-26 10:00:{t:09.6f}",{k},{",".join(map(repr, map(float, r)))}' for k, (t, r) in enumerate(rows)]
    path.write_text("\n".join([*heads, *body]) + "\n", encoding="utf-8")


@pytest.mark.parametrize(
    ("write", "ending"), [(write_matlab, "mat"), (write_simulink, "mat"), (write_npy, "npy"), (write_logger, "csv")]
)
def test_columns_are_taken_by_the_names_that_the_file_gives(tmp_path: Path, write: Any, ending: str) -> None:
    path = tmp_path / f"run.{ending}"
    write(path)
    (block,) = import_sources([path], RIG).blocks
    np.testing.assert_allclose(block.samples, hit(4), rtol=1e-12)
    assert block.rate_hz == pytest.approx(RATE_HZ)


def test_names_of_a_matlab_cell_that_are_not_the_rigs_are_rejected(tmp_path: Path) -> None:
    io.savemat(tmp_path / "x.mat", {"x": hit(4).T, "fs": RATE_HZ, "names": cell(["hammer", "p1", "p2", "p3"])})
    with pytest.raises(DataError, match="names the columns hammer, p1, p2, p3; channel force, a01, a02, a03"):
        import_sources([tmp_path / "x.mat"], RIG)


def test_a_rig_of_matlab_columns_is_drafted_with_their_names(tmp_path: Path) -> None:
    write_matlab(tmp_path / "x.mat")
    assert {c.name for c in draft_mat(tmp_path / "x.mat", ImportOptions()).channels} == set(NAMES)


def test_channels_of_rattlesnake_are_found_by_node_and_unit(tmp_path: Path) -> None:
    points = {c.name: str(c.point) for c in RIG.channels}
    units = ["N" if NAMES[k] == "force" else "m/s^2" for k in ORDER]
    rattlesnake(tmp_path / "run.nc4", [points[name] for name in named()], units)
    (block,) = import_sources([tmp_path / "run.nc4"], RIG).blocks
    np.testing.assert_array_equal(block.samples, hit(4))
    rattlesnake(tmp_path / "other.nc4", ["91", "92", "93", "94"], units)
    with pytest.raises(DataError, match="is no single row of the file's table: 91 Z"):
        import_sources([tmp_path / "other.nc4"], RIG)


LINES = np.arange(10.0, 60.0, 0.5)


def frfs() -> np.ndarray:
    w, w0 = 2 * np.pi * LINES, 2 * np.pi * 31.0
    return np.array([[1.0], [0.4], [-0.7]]) * -(w**2) / (w0**2 - w**2 + 0.02j * w0 * w)


def test_frfs_of_testlab_are_read_with_axis_unit_and_names(tmp_path: Path) -> None:
    values = {"values": frfs()[[2, 0, 1]].T * 1000, "quantity": {"label": "mm/s^2/N"}}
    axis = {"start_value": 10.0, "increment": 0.5, "number_of_values": float(LINES.size)}
    names = np.array([f"FRF {name}:+Z/force:+Z" for name in ("a03", "a01", "a02")], object)
    block = {"x_values": axis, "y_values": values, "function_record": {"name": names}}
    io.savemat(tmp_path / "x.mat", {"FRF": block})
    (frf,) = import_sources([tmp_path / "x.mat"], RIG, ImportOptions(drive_point=RIG.points[0].id)).frfs
    np.testing.assert_allclose(frf.values[[frf.outputs.index(n) for n in NAMES[1:]], 0], frfs(), rtol=1e-9)
    np.testing.assert_allclose(frf.frequency_hz, LINES)


def test_records_of_testlab_are_a_structure_for_each_quantity(tmp_path: Path) -> None:
    force, *responses = hit(4)
    axis = {"start_value": 0.0, "increment": 1 / RATE_HZ, "number_of_values": float(force.size)}

    def block(names: list[str], rows: list[np.ndarray], unit: str) -> dict[str, object]:
        values = {"values": np.array(rows).T, "quantity": {"label": unit}}
        return {"x_values": axis, "y_values": values, "function_record": {"name": np.array(names, object)}}

    signals = {"Signal_0": block(["force"], [force], "N"), "Signal_1": block(list(NAMES[1:]), responses, "g")}
    io.savemat(tmp_path / "x.mat", signals)
    (one,) = import_sources([tmp_path / "x.mat"], RIG).blocks
    np.testing.assert_array_equal(one.samples, hit(4))
    assert (one.rate_hz, one.units) == (RATE_HZ, ("N", "g", "g", "g"))


def stacked(titles: list[str]) -> str:
    tables: list[str] = []
    for title, values in zip(titles, frfs(), strict=True):
        rows = [f"{f}\t{float(v.real)!r}\t{float(v.imag)!r}" for f, v in zip(LINES, values, strict=True)]
        tables.append("\n".join([title, "Frequency [Hz]\tReal\tImag", *rows]))
    return "\n".join(tables) + "\n"


def test_frfs_below_each_other_are_known_by_their_titles(tmp_path: Path) -> None:
    path = tmp_path / "frfs.txt"
    path.write_text(stacked(["FRF a01/force", "Frequency Response H1(a02,force)", "a03"]), encoding="utf-8")
    (frf,) = import_sources([path], RIG, ImportOptions(drive_point=RIG.points[0].id)).frfs
    np.testing.assert_allclose(frf.values[:, 0], frfs(), rtol=1e-12)


def test_frfs_below_each_other_without_a_title_are_rejected(tmp_path: Path) -> None:
    (tmp_path / "frfs.txt").write_text(stacked(["", "", ""]), encoding="utf-8")
    with pytest.raises(DataError, match="3 tables of FRFs below each other, and not the response of each"):
        import_sources([tmp_path / "frfs.txt"], RIG)


def write_structures(path: Path) -> None:
    units = {"force": ("kN", 1e-3), "a02": ("mm/s^2", 1e3)}
    parts = {n: (*units.get(n, ("m/s^2", 1.0)), row) for n, row in zip(NAMES, hit(4), strict=True)}
    if path.suffix == ".mat":
        io.savemat(path, {n: {"data": k * row, "unit": unit, "fs": RATE_HZ} for n, (unit, k, row) in parts.items()})
        return
    with h5py.File(path, "w") as target:
        for name, (unit, k, row) in parts.items():
            target[f"run/{name}"] = k * row
            target[f"run/{name}"].attrs.update({"unit": unit, "fs": RATE_HZ})


@pytest.mark.parametrize("ending", ["mat", "h5"])
def test_the_unit_that_a_file_gives_to_a_channel_counts(tmp_path: Path, ending: str) -> None:
    write_structures(tmp_path / f"x.{ending}")
    (block,) = import_sources([tmp_path / f"x.{ending}"], RIG).blocks
    assert block.units == ("kN", "m/s^2", "mm/s^2", "m/s^2")
    assert block.rate_hz == pytest.approx(RATE_HZ)
    np.testing.assert_allclose(block.samples[0] * 1e3, hit(4)[0], rtol=1e-12)


def test_units_listed_beside_names_count(tmp_path: Path) -> None:
    rows = hit(4)[list(ORDER)] * np.array([[1e3, 1e-3, 1e3, 1e3][k] for k in range(4)])[:, None]
    units = cell(["mm/s^2", "kN", "mm/s^2", "mm/s^2"])
    io.savemat(tmp_path / "x.mat", {"x": rows.T, "fs": RATE_HZ, "chNames": cell(named()), "chUnits": units})
    (block,) = import_sources([tmp_path / "x.mat"], RIG).blocks
    assert block.units == ("kN", "mm/s^2", "mm/s^2", "mm/s^2")


def test_arrays_of_an_npz_are_the_channels_of_their_names(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", time=times(), **dict(zip(NAMES, hit(4), strict=True)))
    (block,) = import_sources([tmp_path / "x.npz"], RIG).blocks
    np.testing.assert_array_equal(block.samples, hit(4))


def test_channels_that_are_structures_of_one_structure_are_found(tmp_path: Path) -> None:
    rows = zip(NAMES, hit(4), strict=True)
    one = {name: {"data": row, "dt": 1 / RATE_HZ, "unit": "kN" if name == "force" else "m/s^2"} for name, row in rows}
    io.savemat(tmp_path / "x.mat", {"rec": one})
    (block,) = import_sources([tmp_path / "x.mat"], RIG).blocks
    assert (block.rate_hz, block.units[0]) == (RATE_HZ, "kN")
    np.testing.assert_array_equal(block.samples, hit(4))


def rows_of(head: str) -> str:
    return head + "".join(f"{t:.9f},{','.join(map(str, row))}\n" for t, row in zip(times(), hit(4).T, strict=True))


UNITS_APART = {
    "x.mat": lambda path: io.savemat(path, {**as_variables(), "units": cell(["s", "N", "g", "g", "g"])}),
    "x.npz": lambda path: np.savez(path, **as_variables(), units=np.array(["s", "N", "g", "g", "g"])),
    "comment.csv": lambda path: path.write_text(rows_of("# Units: s, N, g, g, g\ntime,force,a01,a02,a03\n")),
    "third row.csv": lambda path: path.write_text(
        rows_of("time,force,a01,a02,a03\nModule,Hammer,Acc 1,Acc 2,Acc 3\ns,N,g,g,g\n")
    ),
    "table.csv": lambda path: path.write_text(rows_of("Channel,Unit\nforce,N\na01,g\n\ntime,force,a01,a02,a03\n")),
}


def as_variables() -> dict[str, np.ndarray]:
    return {"time": times(), **dict(zip(NAMES, hit(4), strict=True))}


@pytest.mark.parametrize("name", UNITS_APART)
def test_the_one_unit_that_a_file_has_for_a_quantity_is_that_of_its_channels(tmp_path: Path, name: str) -> None:
    UNITS_APART[name](tmp_path / name)
    (block,) = import_sources([tmp_path / name], RIG).blocks
    assert block.units == ("N", "g", "g", "g")


def test_several_units_of_one_quantity_need_a_channel_each(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", **as_variables(), units=np.array(["s", "N", "g", "g", "m/s^2"]))
    with pytest.raises(DataError, match=r"several units of acceleration, g and m/s\^2, and does not say whose"):
        import_sources([tmp_path / "x.npz"], RIG)


def test_volts_need_a_sensitivity(tmp_path: Path) -> None:
    content = RIG.model_dump(exclude_defaults=True, mode="json")
    channels = [{k: v for k, v in c.items() if k != "sensitivity_v_per_unit"} for c in content["channels"]]
    rig = type(RIG).model_validate(content | {"channels": channels})
    (tmp_path / "x.csv").write_text(rows_of("time [s],force [N],a01 [V],a02 [m/s^2],a03 [m/s^2]\n"))
    stored = type(RIG).model_validate_json(rig.model_dump_json())
    for one in (rig, stored):
        with pytest.raises(DataError, match="channel a01 is in V, and the rig has no sensitivity of it"):
            import_sources([tmp_path / "x.csv"], one)


def test_an_array_of_structures_of_matlab_7_3_has_the_channels_of_their_names(tmp_path: Path) -> None:
    path = tmp_path / "x.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        fields: dict[str, list[h5py.Reference]] = {"name": [], "fs": [], "data": []}
        for k, (name, row) in enumerate(zip(NAMES, hit(4), strict=True)):
            held = {"name": np.array([[ord(c)] for c in name], np.uint16), "fs": RATE_HZ, "data": row[None]}
            for key, value in held.items():
                file[f"#refs#/{key}{k}"] = np.atleast_2d(value)
                file[f"#refs#/{key}{k}"].attrs["MATLAB_class"] = np.bytes_("char" if key == "name" else "double")
                fields[key].append(file[f"#refs#/{key}{k}"].ref)
        for key, references in fields.items():
            file[f"rec/{key}"] = np.array([references], h5py.ref_dtype).T
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116))
    (block,) = import_sources([path], RIG).blocks
    assert block.rate_hz == RATE_HZ
    np.testing.assert_array_equal(block.samples, hit(4))


def save_counts(path: Path, **beside: float) -> Path:
    with h5py.File(path, "w") as file:
        for name, row in zip(NAMES, hit(4), strict=True):
            file[name] = np.round((row - 0.5) * 1e6).astype(np.int32)
            file[name].attrs.update({"fs": RATE_HZ, **beside})
    return path


def test_whole_numbers_are_scaled_as_netcdf_says_it(tmp_path: Path) -> None:
    (block,) = import_sources([save_counts(tmp_path / "x.h5", scale_factor=1e-6, add_offset=0.5)], RIG).blocks
    np.testing.assert_allclose(block.samples, hit(4), atol=1e-6)


def test_whole_numbers_beside_a_gain_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"holds whole numbers beside a gain of 1e-06"):
        import_sources([save_counts(tmp_path / "x.h5", gain=1e-6)], RIG)
