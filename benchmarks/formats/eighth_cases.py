"""An eighth draw: twenty-five files of drawn structures, written after what the seventh showed was mended."""

import json
import struct
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import chunk
from damaged_cases import changed, put
from drawn import Drawn, draws, modes
from known import PLAIN, G, Known, KnownFrf, Record
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from seventh_cases import NAMES, UNITS, frfs, functions, steps, waved
from seventh_table_cases import INCH, LBF, at, cells, rows_of, slow
from tdms_cases import A1, A2, FORCE, thing
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from text_cases import save
from uff_written import ACCELERATION, EDGE, binary_58, nodes_2411, text_58, units_164
from uff_written import save as save_uff

DRIVEN = ("--drive-point", "1")
HEAD = "time [s],force [N],a1 [m/s^2],a2 [m/s^2]"


@draws("eighth")
def lvm_time_of_day_offsets(folder: Path, d: Drawn) -> Known:
    """X_Columns One; Time of each channel differs: the third begins 4 samples later, in the segment's header."""
    d = Drawn(d.modes, 2000.0, d.n, d.seed)
    r = d.hit()
    lines = head(columns="No") + segment([r.force, r.a1, r.a2[4:]], "No", **steps(d))
    place = next(k for k, line in enumerate(lines) if line.startswith("Time\t10:00:01"))
    lines[place] = "Time\t10:00:01.500000\t10:00:01.500000\t10:00:01.502000"
    return Known(save_lvm(folder, lines), (r.part(4),), check=modes(d))


@draws("eighth")
def lvm_product_units(folder: Path, d: Drawn) -> Known:
    """Comma between columns, units m*s^-2 and kN, a comment in the last column."""
    r = d.hit()
    lines = head(",", "One") + segment(
        [r.force / 1e3, r.a1, r.a2], "One", ",", units=("kN", "m*s^-2", "m*s^-2"), comments={3: "ok"}, **steps(d)
    )
    return Known(save_lvm(folder, lines), (r,))


@draws("eighth")
def uff_2414_complex(folder: Path, d: Drawn) -> Known:
    """2411 in SI and complex modes in 2414, data type 5, three components."""
    lines = nodes_2411([(1, 0.1, 0, 0), (2, 0.3, 0, 0)])
    for k, (f0, zeta, phi) in enumerate(d.modes, 1):
        w = 2 * np.pi * f0
        pole = (-zeta * w, w * np.sqrt(1 - zeta**2))
        one = [f"{k:10d}", "modes", f"{1:10d}", *["NONE"] * 5, "".join(f"{v:10d}" for v in (1, 3, 2, 8, 5, 3))]
        one += ["".join(f"{v:10d}" for v in (0, 0, 0, 0, 1, k, 0, 0)), f"{0:10d}{0:10d}"]
        one += ["".join(f"{v:13.5E}" for v in (0, f0, 0, 0, 0, 0)), "".join(f"{v:13.5E}" for v in (*pole, 0, 0, 0, 0))]
        for node, value in enumerate(phi, 1):
            one += [f"{node:10d}", "".join(f"{v:13.5E}" for v in (0, 0, value, 0, 0, 0.1 * value))]
        lines += [EDGE, "  2414", *one, EDGE]

    def right(where: Path) -> str:
        found = json.loads((where / "out.json").read_text())["modes"]
        values = [(m["frequency_hz"], m["damping_ratio"], m["shape"]["1"][1][0], m["shape"]["2"][2][1]) for m in found]
        wanted = [(f0, zeta, phi[0], 0.1 * phi[1]) for f0, zeta, phi in d.modes]
        return "" if np.shape(values) == np.shape(wanted) and np.allclose(values, wanted, rtol=1e-4) else f"{found}"

    return Known(save_uff(folder, lines), check=right, rig=None, options=())


@draws("eighth")
def uff_inch_frfs_by_164(folder: Path, d: Drawn) -> Known:
    """FRFs without labels, dataset 164 of inches and pounds; no rig."""
    right = d.frf()
    scaled = KnownFrf(right.frequency, right.values / INCH * LBF)
    inch = (7, "IN: Inch (pound f)", 39.37007874015748, 0.22480894309971047)
    lines = units_164(inch) + text_58(frfs(scaled, ACCELERATION, "NONE", denominator=(13, "NONE"), double=True))
    return Known(save_uff(folder, lines), check=modes(d), rig=None, options=())


@draws("eighth")
def uff_force_against(folder: Path, d: Drawn) -> Known:
    """58b: FRFs whose reference is 1, -Z: the force points against the responses."""
    right = d.frf()
    turned = KnownFrf(right.frequency, -right.values)
    data = b"".join(binary_58(f) for f in frfs(turned, reference=(1, -3), double=True))
    return Known(save_uff(folder, data), frf=right)


@draws("eighth")
def uff_uneven_times(folder: Path, d: Drawn) -> Known:
    """Records whose abscissa is written sample by sample in single precision."""
    d = Drawn(d.modes, d.rate, 2048, d.seed)
    r = d.hit()
    return Known(save_uff(folder, text_58(functions(r, lines=np.arange(d.n) / d.rate))), (r,))


@draws("eighth")
def tdms_two_hits_and_slow(folder: Path, d: Drawn) -> Known:
    """Two groups of one hit each, and one of a slow channel with its own increment."""
    objects, raw = [thing("/")], b""
    for k in (1, 2):
        objects.append(thing(f"/'hit {k}'"))
        for name, row, facts in zip(NAMES, d.hit(k).rows, waved(d), strict=True):
            objects.append(thing(f"/'hit {k}'/'{name}'", row, facts))
            raw += row.tobytes()
    temperature = np.linspace(20, 21, 30)
    objects += [thing("/'slow'"), thing("/'slow'/'T'", temperature, {"unit_string": "degC", "wf_increment": 0.1})]
    data = tdms_segment(objects, raw + temperature.tobytes())
    return Known(save_tdms(folder, data), (d.hit(1), d.hit(2)), check=modes(d))


@draws("eighth")
def tdms_negative_offset(folder: Path, d: Drawn) -> Known:
    """float32, offsets of -5 samples on the force only: it began before the others."""
    r = d.hit()
    rows = [row.astype("f4") for row in (r.force, r.a1[5:], r.a2[5:])]
    facts = waved(d)
    facts[0] |= {"wf_start_offset": -5 / d.rate}
    facts[1] |= {"wf_start_offset": 0.0}
    facts[2] |= {"wf_start_offset": 0.0}
    objects = [thing("/"), thing("/'hit'")]
    objects += [thing(p, row, f) for p, row, f in zip((FORCE, A1, A2), rows, facts, strict=True)]
    data = tdms_segment(objects, b"".join(row.tobytes() for row in rows))
    return Known(save_tdms(folder, data), (r.part(5),), check=modes(d))


@draws("eighth")
def wav_rf64(folder: Path, d: Drawn) -> Known:
    """RF64: sizes of 0xFFFFFFFF and a chunk ds64, floats in the unit of the rig."""
    d = Drawn(d.modes, float(round(d.rate)), d.n, d.seed)
    r = d.hit()
    data = r.rows.T.astype("<f4").tobytes()
    rate = int(d.rate)
    form = struct.pack("<HHIIHH", 3, 3, rate, rate * 12, 12, 32)
    sizes = struct.pack("<QQQI", 72 + len(data), len(data), d.n, 0)
    body = b"WAVE" + chunk(b"ds64", sizes) + chunk(b"fmt ", form) + chunk(b"data", data, 0xFFFFFFFF)
    (folder / "case.wav").write_bytes(b"RF64" + struct.pack("<I", 0xFFFFFFFF) + body)
    return Known(("case.wav",), (r,))


@draws("eighth")
def matlab_scaled_counts(folder: Path, d: Drawn) -> Known:
    """Structures with data in int16 and a factor beside it."""
    r = d.hit()
    content = {}
    for name, row in zip(NAMES, r.rows, strict=True):
        factor = abs(row).max() / 32000
        content[name] = {"data": np.round(row / factor).astype("i2"), "scale": factor, "fs": d.rate}
    scipy.io.savemat(folder / "case.mat", content)
    return Known(("case.mat",), (r,), rejected="(?i)scale", tolerance=3e-5)


@draws("eighth")
def hdf5_of_xarray(folder: Path, d: Drawn) -> Known:
    """netCDF4 conventions in HDF5: int32 with scale_factor and add_offset, a dimension `time`."""
    r = d.hit()
    with h5py.File(folder / "case.h5", "w") as file:
        file["time"] = r.time
        for name, unit, row in zip(NAMES, UNITS, r.rows, strict=True):
            factor = abs(row).max() / 2**30
            file[name] = np.round((row - 0.5) / factor).astype("i4")
            file[name].attrs.update({"units": unit, "scale_factor": factor, "add_offset": 0.5})
    return Known(("case.h5",), (r,))


@draws("eighth")
def matlab_73_cell_names(folder: Path, d: Drawn) -> Known:
    """Version 5: a matrix (samples, channels) with the names in a row of text, and the time in ms by its unit."""
    r = d.hit()
    content = {"t": r.time, "acc": np.column_stack([r.a1, r.a2]), "F": r.force}
    scipy.io.savemat(folder / "case.mat", content)
    said = ("--variable", "force=F", "a1=acc:1", "a2=acc:2", "time=t")
    return Known(("case.mat",), (r,), options=(*DRIVEN, *said))


@draws("eighth")
def sep_shorter_with_times(folder: Path, d: Drawn) -> Known:
    """SEP005 with the times of each; the last series ends 9 samples earlier."""
    r = d.hit()
    series = [
        {"name": n, "data": row.tolist(), "unit_str": u, "time": (np.arange(len(row)) / d.rate).tolist()}
        for n, u, row in zip(NAMES, UNITS, (r.force, r.a1, r.a2[:-9]), strict=True)
    ]
    (folder / "case.json").write_text(json.dumps(series), encoding="utf-8")
    return Known(("case.json",), (r.part(0, -9),), check=modes(d))


@draws("eighth")
def siglent(folder: Path, d: Drawn) -> Known:
    """An oscilloscope: facts, `Second,Volt,Volt,Volt` above and `Source,CH1,CH2,CH3` between; said by the user."""
    r = d.hit()
    facts = ["Record Length,Analog:4096", f"Sample Interval,{1 / d.rate:.9f}", "Vertical Units,V,V,V", ""]
    rows = rows_of(r, factors=(0.01, 0.01, 0.01), digits=9)
    rig = PLAIN.replace(", point", ", sensitivity_v_per_unit: 0.01, point")
    said = ("--variable", "force=CH1", "a1=CH2", "a2=CH3")
    files = save(folder, [*facts, "Source,CH1,CH2,CH3", "Second,Volt,Volt,Volt", *rows])
    return Known(files, (r,), rig=rig, options=(*DRIVEN, *said))


@draws("eighth")
def endaq(folder: Path, d: Drawn) -> Known:
    """ "X (40g)" as a name: the bracket holds a range and no unit; units by --columns."""
    r = d.hit()
    rows = rows_of(r, factors=(1, 1 / G, 1 / G), digits=9)
    said = ("--columns", "time:s,force:N,a1:g,a2:g")
    files = save(folder, ['"Timestamp","F (2kN)","X (40g)","Z (40g)"', *rows])
    return Known(files, (r,), options=(*DRIVEN, *said))


@draws("eighth")
def spider8(folder: Path, d: Drawn) -> Known:
    """Decimal comma, tabs, times as `10:00:00,000` only to the ms where the rate needs more: rejected."""
    d = Drawn(d.modes, 2048.0, d.n, d.seed)
    rows = [
        row.replace(".", ",")
        for row in rows_of(d.hit(), lambda i: at(i, d.rate, "2026-03-29T10:00:00").strftime("%H:%M:%S.%f")[:-3], "\t")
    ]
    return Known(
        save(folder, ["Time\tforce [N]\ta1 [m/s²]\ta2 [m/s²]", *rows]),
        (d.hit(),),
        rejected="(?i)coarse|digit|ascend|uneven",
        check=modes(d),
        tolerance=1e-3,
    )


@draws("eighth")
def milliseconds_beside_seconds(folder: Path, d: Drawn) -> Known:
    """A clock of whole seconds, and a column of milliseconds beside it."""
    d = slow(d)
    rows = rows_of(
        d.hit(), lambda i: f"{at(i, d.rate, '2026-03-29T10:00:00'):%H:%M:%S},{(i / d.rate * 1e3) % 1000:.3f}"
    )
    head_ = "Time,ms,force [N],a1 [m/s^2],a2 [m/s^2]"
    return Known(
        save(folder, [head_, *rows]),
        (d.hit(),),
        rejected="(?i)coarse|ascend|digit|twice",
        check=modes(d),
        tolerance=1e-3,
    )


@draws("eighth")
def american_date_midnight(folder: Path, d: Drawn) -> Known:
    """12/31/2026 11:59:59.9 PM to 1/1/2027 12:00:00 AM, without zeros in front."""
    d = slow(d)
    r = d.hit()

    def moment(i: int) -> str:
        t = at(i, d.rate, "2026-12-31T23:59:59.9")
        return f"{t.month}/{t.day}/{t.year} {t.hour % 12 or 12}:{t:%M:%S.%f} {'PM' if t.hour >= 12 else 'AM'}"

    return Known(save(folder, [HEAD.replace(" [s]", ""), *rows_of(r, moment)]), (r,), tolerance=1e-4)


@draws("eighth")
def two_line_names(folder: Path, d: Drawn) -> Known:
    """Names in one line, places in the next, units in the third; trailing tabs."""
    r = d.hit()
    lines = ["Time\tforce\ta1\ta2\t", "\tpoint 1\tpoint 1\tpoint 2\t", "s\tN\tm/s²\tm/s²\t"]
    return Known(save(folder, [*lines, *(row + "\t" for row in rows_of(r, between="\t"))], name="case.txt"), (r,))


@draws("eighth")
def frf_functions_of_points(folder: Path, d: Drawn) -> Known:
    """H1(1Z,1Z) and H1(2Z,1Z): level in dB re 1 g/N and degrees, decimal comma, no rig."""
    right = d.frf()
    parts = [v for h in right.values / G for v in (20 * np.log10(abs(h)), np.degrees(np.angle(h)))]
    names = ";".join(f"H1({k}Z,1Z) {p}" for k in (1, 2) for p in ("Magnitude [dB re 1 g/N]", "Phase [Degrees]"))
    rows = [row.replace(".", ",") for row in cells(";", right.frequency, *parts)]
    return Known(save(folder, ["Frequency [Hz];" + names, *rows]), check=modes(d), rig=None, options=())


@draws("eighth")
def frf_pulse_reflex(folder: Path, d: Drawn) -> Known:
    """Two functions below each other: a title, `Freq. [Hz]`, `Real [(m/s²)/N]`, `Imag [(m/s²)/N]`."""
    right = d.frf()
    lines = []
    for name, h in zip(("a1", "a2"), right.values, strict=True):
        lines += [f"Frequency Response H1({name},force)", "Freq. [Hz]\tReal [(m/s²)/N]\tImag [(m/s²)/N]"]
        lines += [*cells("\t", right.frequency, h.real, h.imag), ""]
    return Known(save(folder, lines, "cp1252", name="case.txt"), frf=right)


@draws("eighth")
def frf_dynamic_stiffness(folder: Path, d: Drawn) -> Known:
    """N/m, magnitude and degrees: a stiffness is no receptance."""
    right = d.frf("receptance")
    parts = [v for h in 1 / right.values for v in (abs(h), np.degrees(np.angle(h)))]
    head_ = "f [Hz],Mag a1 [N/m],Phase a1 [deg],Mag a2 [N/m],Phase a2 [deg]"
    return Known(save(folder, [head_, *cells(",", right.frequency, *parts)]), rejected="N/m")


def saturated_below(r: Record) -> Record:
    return changed(r, a2=np.maximum(r.a2, 0.4 * r.a2.min()))


def slow_leak(r: Record) -> Record:
    t = np.arange(len(r.a2)) / len(r.a2)
    return changed(r, a2=r.a2 + 3 * abs(r.a2).max() * t**2)


def marks_for_missing(r: Record) -> Record:
    a = r.a1.copy()
    a[[100, 900]] = -9999.0
    return changed(r, a1=a)


put(
    "only_bottoms_cut",
    "A response is cut off on one side only, in one of two hits.",
    saturated_below,
    "flat bottoms",
    2,
    1,
)
put("zero_that_runs_away", "A zero that runs away in one of two hits.", slow_leak, "zero drifts", 2, 0)
put("minus_9999", "-9999 for missing values.", marks_for_missing, "(?i)neighbouring samples|9999")
