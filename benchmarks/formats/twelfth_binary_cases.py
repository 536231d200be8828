"""A twelfth draw, binary and universal files: units and rates in other places, ratios, objects of MATLAB."""

import json
import struct
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import save as save_array
from array_cases import wave
from damaged_cases import LEFT_OUT
from drawn import Drawn, draws, modes, modes_or_said
from known import RATE, VOLTS, Known, KnownFrf
from seventh_cases import NAMES, UNITS, frfs, functions
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from tdms_cases import thing
from tenth_cases import DRIVEN
from uff_written import ACCELERATION, Function, text_58
from uff_written import FORCE as FORCES
from uff_written import save as save_uff

UNKNOWN = 0


@draws("twelfth")
def uff_ratio_in_one_label(folder: Path, d: Drawn) -> Known:
    """FRFs whose ordinate's label says the ratio, g/N, and whose denominator says nothing."""
    right = d.frf()
    scaled = KnownFrf(right.frequency, right.values / 9.80665)
    written = frfs(scaled, ACCELERATION, "g/N", denominator=(UNKNOWN, "NONE"), double=True)
    return Known(save_uff(folder, text_58(written)), frf=right, rejected="(?i)g/N")


@draws("twelfth")
def uff_transmissibility(folder: Path, d: Drawn) -> Known:
    """Function type 5: ratios of two accelerations, which give no modal mass."""
    right = d.frf()
    ratio = right.values[1] / right.values[0]
    f = Function(ratio, 0.25, 0.25, kind=5, response=(2, 3), reference=(1, 3), ordinate=(ACCELERATION, "m/s^2"),
                 denominator=(ACCELERATION, "m/s^2"), double=True)  # fmt: skip
    return Known(
        save_uff(folder, text_58([f])), rejected="(?i)transmissib|type 5|no FRF|no time rec", rig=None, options=()
    )


@draws("twelfth")
def uff_both_against(folder: Path, d: Drawn) -> Known:
    """Response and reference both along -Z: two signs that cancel; 2Z beside them has one."""
    right = d.frf()
    a, b = frfs(right, double=True)
    a = Function(
        a.values, a.step, a.first, 4, (1, -3), (1, -3), ordinate=a.ordinate, denominator=a.denominator, double=True
    )
    b = Function(
        -b.values, b.step, b.first, 4, (2, 3), (1, -3), ordinate=b.ordinate, denominator=b.denominator, double=True
    )
    return Known(save_uff(folder, text_58([a, b])), frf=right)


@draws("twelfth")
def uff_gated_force(folder: Path, d: Drawn) -> Known:
    """The force's record holds the first 256 samples only, as a gate on the hit leaves it."""
    r = d.hit()
    force, a, b = functions(r, double=True)
    short = Function(force.values[:256], force.step, response=(1, 3), ordinate=(FORCES, "N"), double=True)
    return Known(save_uff(folder, text_58([short, a, b])), (r,), rejected="(?i)256", check=modes(d))


@draws("twelfth")
def tdms_units_in_names(folder: Path, d: Drawn) -> Known:
    """Channels `force (N)`, `a1 (g)`, `a2 (g)` without unit_string; no rig."""
    r = d.hit()
    rows = [r.force, r.a1 / 9.80665, r.a2 / 9.80665]
    objects = [thing("/"), thing("/'hit'")]
    objects += [thing(f"/'hit'/'{n} ({u})'", row, {"wf_increment": 1 / d.rate})
                for n, row, u in zip(NAMES, rows, ("N", "g", "g"), strict=True)]  # fmt: skip
    said = ("--variable", "force=force (N)", "a1=a1 (g)", "a2=a2 (g)")
    files = save_tdms(folder, tdms_segment(objects, b"".join(row.tobytes() for row in rows)))
    return Known(files, (r,), options=(*DRIVEN, *said), rejected="(?i)unit")


@draws("twelfth")
def tdms_rate_at_the_top(folder: Path, d: Drawn) -> Known:
    """The rate stands once, as a property of the file: SampleRate."""
    r = d.hit()
    objects = [thing("/", None, {"SampleRate": d.rate}), thing("/'hit'")]
    objects += [thing(f"/'hit'/'{n}'", row, {"unit_string": u}) for n, row, u in zip(NAMES, r.rows, UNITS, strict=True)]
    return Known(
        save_tdms(folder, tdms_segment(objects, b"".join(row.tobytes() for row in r.rows))), (r,), rejected="--rate"
    )


@draws("twelfth")
def matlab_timetable(folder: Path, d: Drawn) -> Known:
    """Version 7.3 with a timetable: an object of MATLAB, whose numbers only MATLAB finds."""
    with h5py.File(folder / "case.mat", "w", userblock_size=512) as file:
        item = file.create_dataset("hit", data=np.array([[3707764736, 2, 1, 1, 1, 1]], "u4"))
        item.attrs["MATLAB_class"] = np.bytes_("timetable")
        item.attrs["MATLAB_object_decode"] = np.int32(3)
        file.create_group("#subsystem#").create_dataset("MCOS", data=d.hit().rows)
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + struct.pack("<H", 0x0200) + b"IM"
    with (folder / "case.mat").open("r+b") as file:
        file.write(head)
    return Known(("case.mat",), rejected="(?i)timetable|object|table")


@draws("twelfth")
def matlab_names_of_a_matrix(folder: Path, d: Drawn) -> Known:
    """A structure: time, y (samples, channels), a padded matrix of characters as names, a cell of units."""
    r = d.hit()
    units = np.array(["kN", "m/s^2", "g"], object)
    y = (r.rows * np.array([1e-3, 1, 1 / 9.80665])[:, None]).T
    fields = {"time": r.time[:, None], "y": y, "names": np.array(["force", "a1   ", "a2   "]), "units": units}
    scipy.io.savemat(folder / "case.mat", {"meas": fields})
    return Known(("case.mat",), (r,), rejected="(?i)--map|--variable")


@draws("twelfth")
def hdf5_group_a_channel(folder: Path, d: Drawn) -> Known:
    """A group a channel with values and time, the unit an attribute of the group; the force in kN."""
    r = d.hit()
    with h5py.File(folder / "case.h5", "w") as file:
        for name, row, unit, k in zip(NAMES, r.rows, ("kN", "m/s^2", "m/s^2"), (1e-3, 1, 1), strict=True):
            group = file.create_group(f"measurement/{name}")
            group["values"], group["time"] = row * k, r.time
            group.attrs["unit"] = unit
    said = ("--variable", "time=measurement/force/time", *(f"{n}=measurement/{n}/values" for n in NAMES))
    return Known(("case.h5",), (r,), options=(*DRIVEN, *said), rejected="(?i)unit|kN|map")


@draws("twelfth")
def wav_clipped(folder: Path, d: Drawn) -> Known:
    """16 bit, the first response driven into full scale."""
    d = Drawn(((60.0, 0.01, (0.6, 0.5)), (150.0, 0.012, (0.5, -0.8))), RATE, 4096, d.seed)
    r = d.hit()
    full = 0.4 * abs(r.a1).max()
    scaled = r.rows.T / np.array([1.2 * abs(r.force).max(), full, 1.2 * abs(r.a2).max()])
    counts = np.round(scaled * 32768).clip(-32768, 32767).astype("<i2")
    rig = VOLTS
    files = save_array(folder, "case.wav", wave(counts.tobytes(), 1, 16))
    check = modes_or_said(d, LEFT_OUT, scaled=False)
    return Known(files, check=check, rig=rig, options=(*DRIVEN, "--volts"), says="a1.*(flat|full scale|clip|limit)",
                 rejected="a1.*(flat|full scale|clip|limit)")  # fmt: skip


@draws("twelfth")
def sep_null(folder: Path, d: Drawn) -> Known:
    """null in three places of the second series."""
    r = d.hit()
    series = [
        {"name": n, "data": row.tolist(), "unit_str": u, "fs": d.rate}
        for n, row, u in zip(NAMES, r.rows, UNITS, strict=True)
    ]
    series[1]["data"][500:503] = [None] * 3
    (folder / "case.json").write_text(json.dumps(series), encoding="utf-8")
    return Known(
        ("case.json",),
        says="a1",
        rejected="(?i)a1.*(null|missing|no number|not a number|NaN|None)",
        check=modes_or_said(d, LEFT_OUT),
    )


@draws("twelfth")
def json_dictionary(folder: Path, d: Drawn) -> Known:
    """A dictionary of lists by name, as scripts dump it: no SEP005."""
    r = d.hit()
    names = ("time", *NAMES)
    columns = dict(zip(names, (r.time.tolist(), *(row.tolist() for row in r.rows)), strict=True))
    (folder / "case.json").write_text(json.dumps(columns), encoding="utf-8")
    return Known(("case.json",), (r,), rejected="(?i)SEP005|list")


@draws("twelfth")
def column_store(folder: Path, d: Drawn) -> Known:
    """A Parquet file by its first and last four bytes."""
    files = save_array(folder, "case.parquet", b"PAR1" + d.hit().rows.tobytes() + struct.pack("<I", 64) + b"PAR1")
    return Known(files, rejected="(?i)parquet")


@draws("twelfth")
def npz_frf_by_lines(folder: Path, d: Drawn) -> Known:
    """complex64 FRFs (lines, outputs), freq and frf."""
    right = d.frf()
    np.savez(folder / "case.npz", freq=right.frequency, frf=right.values.T.astype("c8"))
    said = ("--variable", "frequency=freq")
    return Known(("case.npz",), frf=right, options=(*DRIVEN, *said), rejected="(?i)map|axes|order", tolerance=1e-4)
