"""An eleventh draw: containers beside those that are read, times in other words, and FRFs over other abscissae."""

import json
import struct
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import save as save_array
from drawn import Drawn, draws
from known import DISPLACEMENT, Known
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from seventh_cases import NAMES, functions, waved
from seventh_table_cases import at, cells, rows_of, slow
from tdms_cases import A1, A2, FORCE, text, thing
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from tenth_cases import DRIVEN, HEAD
from text_cases import save
from uff_written import Function, nodes_2411, shapes_55, text_58
from uff_written import save as save_uff


@draws("eleventh")
def frf_over_periods(folder: Path, d: Drawn) -> Known:
    """FRFs over the period in s, which falls as the frequency rises."""
    right = d.frf()
    a, b = right.values
    rows = cells(",", 1 / right.frequency, a.real, a.imag, b.real, b.imag)
    names = "Period [s],a1 re [m/s²/N],a1 im [m/s²/N],a2 re [m/s²/N],a2 im [m/s²/N]"
    return Known(save(folder, [names, *rows]), frf=right, rejected="(?i)period")


@draws("eleventh")
def attribute_relation_file(folder: Path, d: Drawn) -> Known:
    """Weka's format: @relation, an @attribute for each column, @data, numbers behind commas."""
    r = d.hit()
    top = ["% a hit", "@relation hit", "", *(f"@attribute {n} numeric" for n in ("time", *NAMES)), "", "@data"]
    files = save(folder, [*top, *rows_of(r)], name="case.csv")
    return Known(files, (r,), rejected="(?i)no line above it names|@data|--columns")


@draws("eleventh")
def negatives_in_brackets(folder: Path, d: Drawn) -> Known:
    """Numbers below zero as accountants write them, (1.25)."""
    r = d.hit()
    rows = [f"{t:.9f}," + ",".join(f"({-v:.7f})" if v < 0 else f"{v:.7f}" for v in row)
            for t, row in zip(r.time, r.rows.T, strict=True)]  # fmt: skip
    return Known(save(folder, [HEAD, *rows]), (r,), rejected=r"\(\d")


@draws("eleventh")
def clock_of_an_audio_editor(folder: Path, d: Drawn) -> Known:
    """Times as 0h00m00.000488s."""
    d = slow(d)
    r = d.hit()
    rows = rows_of(r, lambda i: f"0h{i / d.rate // 60:02.0f}m{i / d.rate % 60:09.6f}s")
    return Known(save(folder, [HEAD.replace(" [s]", ""), *rows]), (r,), rejected="0h00m00")


@draws("eleventh")
def facts_in_hundredths(folder: Path, d: Drawn) -> Known:
    """A factor for each channel above the table: `Scale,1,0.01,0.01,0.01`, to be multiplied with."""
    r = d.hit()
    names = ["Name,time,force,a1,a2", "Unit,s,N,m/s^2,m/s^2", "Scale,1,0.01,0.01,0.01"]
    rows = [f",{row}" for row in rows_of(r, factors=(100, 100, 100), digits=5)]
    return Known(save(folder, [*names, *rows]), (r,), rejected="(?i)scale")


@draws("eleventh")
def receptance_over_radians(folder: Path, d: Drawn) -> Known:
    """Receptances in mm/kN over omega in rad/s, magnitudes in dB of 1 mm/kN and degrees in steps of 360."""
    right = d.frf("receptance")
    parts = [v for h in right.values for v in (20 * np.log10(abs(h) * 1e6), np.degrees(np.angle(h)) + 360)]
    names = "omega [rad/s];a1 [dB re mm/kN];a1 phase [deg];a2 [dB re mm/kN];a2 phase [deg]"
    rows = cells(";", 2 * np.pi * right.frequency, *parts)
    return Known(save(folder, [names, *rows]), frf=right, rig=DISPLACEMENT, rejected="(?i)dB re", tolerance=1e-4)


@draws("eleventh")
def lvm_descriptions(folder: Path, d: Drawn) -> Known:
    """Names with their physical channel, `force (cDAQ1Mod1/ai0)`, asked for by --variable; a decimal comma."""
    r = d.hit()
    names = ("force (cDAQ1Mod1/ai0)", "a1 (cDAQ1Mod1/ai1)", "a2 (cDAQ1Mod2/ai0)")
    lines = segment(list(r.rows), "One", decimal=",", delta=(1 / d.rate,) * 3, names=names)
    said = ("--variable", *(f"{n.split()[0]}={n}" for n in names))
    return Known(save_lvm(folder, head(decimal=",") + lines), (r,), options=(*DRIVEN, *said))


@draws("eleventh")
def uff_shapes_of_six_freedoms(folder: Path, d: Drawn) -> Known:
    """Normal modes with rotations behind the motions, modal mass 4 and shapes twice those of unit mass."""
    lines = nodes_2411([(1, 0.1, 0, 0), (2, 0.3, 0, 0)])
    for k, (f0, zeta, phi) in enumerate(d.modes, 1):
        shape = {n: (0, 0, 2 * v, 9.0, 8.0, 7.0) for n, v in enumerate(phi, 1)}
        lines += shapes_55(k, (f0, 4.0, zeta, 0.0), shape, values=6)

    def right(where: Path) -> str:
        found = json.loads((where / "out.json").read_text())["modes"]
        values = [(m["frequency_hz"], m["damping_ratio"], *(m["shape"][n][2][0] for n in "12")) for m in found]
        wanted = [(f0, zeta, *(2 * v for v in phi)) for f0, zeta, phi in d.modes]
        return "" if np.shape(values) == np.shape(wanted) and np.allclose(values, wanted, rtol=1e-3) else f"{found}"

    return Known(save_uff(folder, lines), check=right, rig=None, options=())


@draws("eleventh")
def uff_against_z(folder: Path, d: Drawn) -> Known:
    """The second sensor along -z: what it measures has the other sign than the rig's channel."""
    r = d.hit()
    force, first, second = functions(r, double=True)
    turned = Function(-second.values, second.step, response=(2, -3), ordinate=second.ordinate, double=True)
    return Known(save_uff(folder, text_58([force, first, turned])), (r,))


@draws("eleventh")
def tdms_remarks(folder: Path, d: Drawn) -> Known:
    """A channel of strings beside those of numbers."""
    r = d.hit()
    objects = [thing("/"), thing("/'hit'")]
    objects += [thing(p, row, f) for p, row, f in zip((FORCE, A1, A2), r.rows, waved(d), strict=True)]
    words = b"startend"
    index = struct.pack("<IIIQQ", 28, 0x20, 1, 2, 8 + len(words)) + struct.pack("<I", 0)
    objects.append(text("/'hit'/'remarks'") + index)
    raw = b"".join(row.tobytes() for row in r.rows) + struct.pack("<II", 5, 8) + words
    return Known(save_tdms(folder, tdms_segment(objects, raw)), (r,))


@draws("eleventh")
def tdms_index_alone(folder: Path, d: Drawn) -> Known:
    """The index that LabVIEW writes beside a file: it begins with TDSh and holds no samples."""
    objects = [thing("/"), thing("/'hit'")]
    objects += [thing(p, row, f) for p, row, f in zip((FORCE, A1, A2), d.hit().rows, waved(d), strict=True)]
    data = tdms_segment(objects, b"\0" * 8)[:-8]
    files = save_array(folder, "case.tdms_index", b"TDSh" + data[4:])
    return Known(files, rejected="(?i)index|no samples|TDSh")


@draws("eleventh")
def matlab_clock_texts(folder: Path, d: Drawn) -> Known:
    """Times as rows of characters, 28-Nov-2026 10:00:00.000488 as datestr writes them, in a cell array."""
    d = slow(d)
    r = d.hit()
    times = np.array([f"{at(i, d.rate, '2026-11-28T10:00:00'):%d-%b-%Y %H:%M:%S.%f}" for i in range(d.n)], object)
    scipy.io.savemat(folder / "case.mat", {"time": times[:, None], "force": r.force, "a1": r.a1, "a2": r.a2})
    return Known(("case.mat",), (r,), rejected="(?i)time")


@draws("eleventh")
def matlab_ticks(folder: Path, d: Drawn) -> Known:
    """Whole microseconds as time_us, whose name says the unit."""
    d = slow(d)
    r = d.hit()
    ticks = np.round(1e6 * r.time).astype("i8")
    scipy.io.savemat(folder / "case.mat", {"time_us": ticks, "force": r.force, "a1": r.a1, "a2": r.a2})
    said = ("--variable", "time=time_us")
    return Known(("case.mat",), (r,), options=(*DRIVEN, *said), rejected="(?i)time_us|converter of a bench")


@draws("eleventh")
def hdf5_rate_in_words(folder: Path, d: Drawn) -> Known:
    """A dataset a channel, compressed, big end first; the rate as the text of an attribute."""
    r = d.hit()
    with h5py.File(folder / "case.h5", "w") as file:
        for name, row in zip(NAMES, r.rows, strict=True):
            file.create_dataset(name, data=row.astype(">f8"), compression="gzip", chunks=(256,))
        file.attrs["sampling_rate"] = f"{d.rate:.0f} Hz"
    return Known(("case.h5",), (r,), rejected="(?i)rate")


@draws("eleventh")
def sep_in_mixed_units(folder: Path, d: Drawn) -> Known:
    """Force in kN, one acceleration in mm/s², the other in mg; fs as text, as some programs write JSON."""
    r = d.hit()
    factors = (1e-3, 1e3, 1e3 / 9.80665)
    series = [
        {"name": n, "data": (row * k).tolist(), "unit_str": u, "fs": f"{d.rate:.1f}"}
        for n, row, k, u in zip(NAMES, r.rows, factors, ("kN", "mm/s²", "mg"), strict=True)
    ]
    (folder / "case.json").write_text(json.dumps(series), encoding="utf-8")
    return Known(("case.json",), (r,), rejected="(?i)fs")
