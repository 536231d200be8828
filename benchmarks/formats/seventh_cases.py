"""A seventh draw: universal files, TDMS, LVM, WAV, MATLAB and HDF5 of drawn structures, to the modes that they hold."""

import json
import struct
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import GUID, chunk
from drawn import Drawn, draws, modes
from known import PLAIN, VELOCITY, G, Known, KnownFrf, Record
from lvm_cases import head, number, segment
from lvm_cases import save as save_lvm
from tdms_cases import A1, A2, FORCE, Time, prop, scaled, text, thing
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from uff_written import ACCELERATION, DISPLACEMENT, EDGE, Function, binary_58, header_151, nodes_15, text_58
from uff_written import FORCE as FORCES
from uff_written import VELOCITY as MOVING
from uff_written import save as save_uff

DRIVEN = ("--drive-point", "1")
NAMES = ("force", "a1", "a2")
UNITS = ("N", "m/s^2", "m/s^2")
PER_G = PLAIN.replace("unit: m/s^2", "unit: g").replace(", point", ", sensitivity_v_per_unit: 0.01, point")


def steps(d: Drawn) -> dict:
    return {"delta": (1 / d.rate,) * 3}


def waved(d: Drawn, **more: object) -> list[dict]:
    return [{"unit_string": u, "wf_increment": 1 / d.rate} | more for u in UNITS]


def functions(record: Record, units: tuple[str, ...] = UNITS, nodes=((1, 3), (1, 3), (2, 3)), **more) -> list[Function]:
    kinds = (FORCES, ACCELERATION, ACCELERATION)
    return [
        Function(row, 1 / record.rate, response=node, ordinate=(kind, unit), **more)
        for row, node, kind, unit in zip(record.rows, nodes, kinds, units, strict=True)
    ]


def frfs(right: KnownFrf, kind: int = ACCELERATION, unit: str = "m/s^2", nodes=((1, 3), (2, 3)), **more):
    first, step = right.frequency[0], right.frequency[1] - right.frequency[0]
    common = {"kind": 4, "reference": nodes[0], "ordinate": (kind, unit), "denominator": (FORCES, "N")}
    common |= {"step": float(step), "first": float(first)} | more
    return [Function(h, response=n, **common) for n, h in zip(nodes, right.values, strict=True)]


@draws("seventh")
def lvm_shorter_last_channel(folder: Path, d: Drawn) -> Known:
    """X_Columns Multi; the last channel has seven samples less, as Samples says."""
    record = d.hit()
    rows = [record.force, record.a1, record.a2[:-7]]
    files = save_lvm(folder, head(columns="Multi") + segment(rows, "Multi", **steps(d)))
    return Known(files, (record.part(0, -7),), check=modes(d))


@draws("seventh")
def lvm_absolute_x(folder: Path, d: Drawn) -> Known:
    """Three segments with a header each, X0 in seconds since 1904 in X_Columns One, decimal comma, Newtons and g."""
    records = [d.hit(k) for k in (1, 2, 3)]
    lines = head(decimal=",", multi="Yes")
    for k, r in enumerate(records):
        part = segment([r.force, r.a1 / G, r.a2 / G], "No", decimal=",", units=("Newtons", "g", "g"), **steps(d))
        x0 = 3786912001 + 8 * k
        at = part.index("***End_of_Header***\t\t\t") + 2
        part[at:-1] = [f"{x0 + i / d.rate:.6f}".replace(".", ",") + row for i, row in enumerate(part[at:-1])]
        lines += [row if not row.startswith("X0") else "X0" + f"\t{x0},000000" * 3 for row in part]
    return Known(save_lvm(folder, lines), tuple(records))


@draws("seventh")
def lvm_smallest_header(folder: Path, d: Drawn) -> Known:
    """Only what the specification requires: no units, no Delta_X, LabVIEW's own names, said by the user."""
    r = d.hit()
    lines = ["LabVIEW Measurement", "Separator\tTab", "Multi_Headings\tNo", "***End_of_Header***", ""]
    lines += ["Channels\t3", f"Samples\t{d.n}\t{d.n}\t{d.n}", "***End_of_Header***"]
    lines += ["X_Value\tUntitled\tUntitled 1\tUntitled 2\tComment"]
    lines += ["\t".join(["", *(number(v) for v in row)]) for row in r.rows.T]
    said = ("--variable", "force=Untitled", "a1=Untitled 1", "a2=Untitled 2", "--rate", str(d.rate))
    return Known(save_lvm(folder, lines), (r,), options=(*DRIVEN, *said))


@draws("seventh")
def lvm_special_between_segments(folder: Path, d: Drawn) -> Known:
    """A special block stands between two segments, after the first one's rows."""
    special = ["***Start_Special***", "NI Fuse\t2", "0.0\t1.0\t2.0\t3.0", "***End_Special***", ""]
    lines = head(multi="Yes") + segment(list(d.hit(1).rows), **steps(d)) + special
    lines += segment(list(d.hit(2).rows), **steps(d))
    return Known(save_lvm(folder, lines), (d.hit(1), d.hit(2)), check=modes(d))


@draws("seventh")
def lvm_volts(folder: Path, d: Drawn) -> Known:
    """Y_Unit_Label Volts and mV; the rig knows 10 mV a unit, and g."""
    r = d.hit()
    rows = [r.force * 0.01, r.a1 / G * 10, r.a2 / G * 10]
    lines = head() + segment(rows, units=("Volts", "mV", "mV"), **steps(d))
    return Known(save_lvm(folder, lines), (r,), rig=PER_G)


@draws("seventh")
def lvm_nan(folder: Path, d: Drawn) -> Known:
    """One cell holds NaN."""
    lines = head() + segment(list(d.hit().rows), **steps(d))
    cells = lines[900].split("\t")
    lines[900] = "\t".join([*cells[:2], "NaN", *cells[3:]])
    return Known(save_lvm(folder, lines), rejected="(?i)nan|missing")


@draws("seventh")
def uff_blank_words(folder: Path, d: Drawn) -> Known:
    """Identification lines are empty, trailing blanks are cut off, exponents are D, inertances in double precision."""
    right = d.frf()
    lines = [
        line.replace("NONE", "    ").replace("one function of a case", "") for line in text_58(frfs(right, double=True))
    ]
    lines = [line.replace("E+", "D+").replace("E-", "D-").rstrip() for line in lines]
    return Known(save_uff(folder, lines), frf=right)


@draws("seventh")
def uff_two_references_drafted(folder: Path, d: Drawn) -> Known:
    """58b, big-endian, mobilities to points 1 and 2, no rig."""
    f = d.lines
    h = d.motion(f, 1, (0, 1))
    sets = []
    for k in (0, 1):
        right = KnownFrf(f, h[:, k], "mobility")
        sets += frfs(right, MOVING, "m/s", double=True, reference=(k + 1, 3))
    return Known(save_uff(folder, b"".join(binary_58(s, big=True) for s in sets)), check=modes(d), rig=None, options=())


@draws("seventh")
def uff_nodes_of_three_digits(folder: Path, d: Drawn) -> Known:
    """Nodes 101 and 102 along X, FRFs, coherences and auto spectra, no rig."""
    right = d.frf()
    nodes = ((101, 1), (102, 1))
    ones = KnownFrf(right.frequency, np.full_like(right.values, 0.999).real.astype(float))
    sets = [s for pair in zip(frfs(right, nodes=nodes), frfs(ones, 0, "NONE", nodes=nodes), strict=True) for s in pair]
    sets = [
        s if k % 2 == 0 else Function(**{**s.__dict__, "kind": 6, "denominator": (0, "NONE")})
        for k, s in enumerate(sets)
    ]
    sets.append(Function(abs(right.values[0]), 0.25, 0.25, kind=2, response=(101, 1), ordinate=(ACCELERATION, "m/s^2")))
    return Known(save_uff(folder, text_58(sets)), check=modes(d), rig=None, options=())


@draws("seventh")
def uff_records_without_nodes(folder: Path, d: Drawn) -> Known:
    """Records of node 0 without a direction; their names stand in the first identification line only."""
    r = d.hit()
    lines = []
    for name, f in zip(NAMES, functions(r, nodes=((0, 0),) * 3, double=True), strict=True):
        one = text_58([f])
        one[2] = name
        lines += one
    return Known(save_uff(folder, lines), (r,))


@draws("seventh")
def uff_exponents_of_three_digits(folder: Path, d: Drawn) -> Known:
    """Fortran leaves out the letter of an exponent of three digits: 1.23450-101."""
    r = d.hit()
    force = r.force.copy()
    force[:20] = 0.0
    r = Record(force, r.a1, r.a2, r.rate)
    lines = text_58(functions(r))
    lines = [line.replace("  0.00000E+00", "  1.23450-101", 3) if k > 13 else line for k, line in enumerate(lines)]
    return Known(save_uff(folder, lines), (r,), tolerance=1e-5)


@draws("seventh")
def uff_stars(folder: Path, d: Drawn) -> Known:
    """A number that did not fit its field: Fortran writes stars."""
    lines = text_58(functions(d.hit()))
    lines[40] = lines[40][:13] + "*" * 13 + lines[40][26:]
    return Known(save_uff(folder, lines), rejected=r"\*\*\*")


@draws("seventh")
def uff_2414_modes(folder: Path, d: Drawn) -> Known:
    """Datasets 151, 15, 82 and normal modes in 2414, as a finite-element program writes them."""
    lines = header_151() + nodes_15([(1, 0.1, 0, 0), (2, 0.3, 0.05, 0)])
    lines += [EDGE, "    82", f"{1:10d}{2:10d}{7:10d}", "trace", f"{1:10d}{2:10d}", EDGE]
    for k, (f0, zeta, phi) in enumerate(d.modes, 1):
        one = [f"{k:10d}", f"mode {k}", f"{1:10d}", "NONE", "NONE", "NONE", "NONE", "NONE"]
        one.append("".join(f"{v:10d}" for v in (1, 2, 3, 8, 2, 6)))
        one += ["".join(f"{v:10d}" for v in (0, 0, 0, 0, 1, k, 0, 0)), f"{0:10d}{0:10d}"]
        one.append("".join(f"{v:13.5E}" for v in (0, f0, 0, 1.0, zeta, 0)))
        one.append("".join(f"{0:13.5E}" for v in range(6)))
        for node, value in enumerate(phi, 1):
            one += [f"{node:10d}", "".join(f"{v:13.5E}" for v in (0, 0, value, 0, 0, 0))]
        lines += [EDGE, "  2414", *one, EDGE]

    def right(where: Path) -> str:
        found = json.loads((where / "out.json").read_text())["modes"]
        values = [(m["frequency_hz"], m["damping_ratio"], *(m["shape"][k][2][0] for k in "12")) for m in found]
        wanted = [(f0, zeta, *phi) for f0, zeta, phi in d.modes]
        return "" if np.shape(values) == np.shape(wanted) and np.allclose(values, wanted, rtol=1e-4) else f"{found}"

    return Known(save_uff(folder, lines), check=right, rig=None, options=())


@draws("seventh")
def tdms_daqmx_polynomial(folder: Path, d: Drawn) -> Known:
    """Raw data of DAQmx: int32 with a polynomial a channel, two segments, the second without metadata."""
    r = d.hit()
    slopes = [abs(row).max() / 2**30 for row in r.rows]
    counts = np.array([np.round(row / s - 1000) for row, s in zip(r.rows, slopes, strict=True)]).astype("<i4")
    half = d.n // 2
    objects = [thing("/"), thing("/'hit'")]
    for k, (path, unit) in enumerate(zip((FORCE, A1, A2), waved(d), strict=True)):
        index = struct.pack("<IIIQ", 0x1269, 0xFFFFFFFF, 1, half)
        index += struct.pack("<IIIIII", 1, 5, 0, 4 * k, 0, 0) + struct.pack("<II", 1, 12)
        facts = {"Type": "Polynomial", "Polynomial_Coefficients_Size": 4, "Polynomial_Input_Source": 0}
        facts |= {f"Polynomial_Coefficients[{i}]": v for i, v in enumerate((1000 * slopes[k], slopes[k], 0.0, 0.0))}
        props = unit | {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 2} | scaled(1, facts)
        objects.append(
            text(path) + index + struct.pack("<I", len(props)) + b"".join(prop(a, b) for a, b in props.items())
        )
    data = tdms_segment(objects, counts[:, :half].T.tobytes()) + tdms_segment(
        [], counts[:, half:].T.tobytes(), new=False
    )
    return Known(save_tdms(folder, data), (r,), rejected="(?i)daqmx")


@draws("seventh")
def tdms_of_modules(folder: Path, d: Drawn) -> Known:
    """Channels cDAQ1Mod1/ai0 to ai2, a start time of each, the third two samples later; said with --variable."""
    r = d.hit()
    rows = [r.force, r.a1, r.a2[2:]]
    paths = [f"/'Log'/'cDAQ1Mod1/ai{k}'" for k in range(3)]
    objects = [thing("/", props={"name": "Log"}), thing("/'Log'")]
    for k, (p, row) in enumerate(zip(paths, rows, strict=True)):
        facts = waved(d)[k] | {
            "wf_start_time": Time(3787000000.25 + (2 / d.rate if k == 2 else 0)),
            "wf_start_offset": 0.0,
        }
        objects.append(thing(p, row, facts))
    said = ("--variable", *(f"{n}=cDAQ1Mod1/ai{k}" for k, n in enumerate(NAMES)))
    data = tdms_segment(objects, b"".join(row.tobytes() for row in rows))
    return Known(save_tdms(folder, data), (r.part(2),), options=(*DRIVEN, *said), check=modes(d))


@draws("seventh")
def wav_24_in_32(folder: Path, d: Drawn) -> Known:
    """Extensible: 24 valid bits in containers of 32, chunks JUNK and bext before; volts of sensors of 10 mV a unit."""
    r = d.hit()
    volts = np.column_stack([r.force * 0.01, r.a1 / G * 0.01, r.a2 / G * 0.01])
    full = 2.0 ** np.ceil(np.log2(abs(volts).max()))
    counts = (np.round(volts / full * (2**23 - 1)).astype("<i4") << 8).tobytes()
    rate = int(d.rate)
    form = struct.pack("<HHIIHH", 0xFFFE, 3, rate, rate * 12, 12, 32) + struct.pack("<HHI", 22, 24, 7)
    body = b"WAVE" + chunk(b"JUNK", b"\0" * 28) + chunk(b"bext", b"\0" * 602)
    body += chunk(b"fmt ", form + struct.pack("<H", 1) + GUID) + chunk(b"data", counts)
    (folder / "case.wav").write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)
    rig = PER_G.replace("0.01", repr(float(0.01 / full)))
    return Known(("case.wav",), (r,), rig=rig, options=(*DRIVEN, "--volts"))


@draws("seventh")
def matlab_of_bk(folder: Path, d: Drawn) -> Known:
    """Channel_1_Data with Channel_1_Header.SignalName, .Unit and .SampleFrequency; File_Header beside them."""
    r = d.hit()
    content = {"File_Header": {"NumberOfChannels": "3", "Date": "29-03-2026", "SampleFrequency": str(d.rate)}}
    for k, (name, unit, row) in enumerate(zip(NAMES, ("N", "g", "g"), (r.force, r.a1 / G, r.a2 / G), strict=True), 1):
        facts = {"SignalName": name, "Unit": unit, "SampleFrequency": d.rate, "NoOfSamples": len(row), "Title": "hit"}
        content |= {f"Channel_{k}_Data": row[:, None], f"Channel_{k}_Header": facts}
    scipy.io.savemat(folder / "case.mat", content)
    said = (
        "--variable",
        *(f"{n}=Channel_{k}_Data" for k, n in enumerate(NAMES, 1)),
        "rate=Channel_1_Header.SampleFrequency",
    )
    return Known(("case.mat",), (r,), rig=PER_G, options=(*DRIVEN, *said))


@draws("seventh")
def matlab_73_struct_array(folder: Path, d: Drawn) -> Known:
    """Version 7.3: a structure array of three channels, whose fields are references."""
    r = d.hit()
    with h5py.File(folder / "case.mat", "w", userblock_size=512) as file:
        held = file.create_group("#refs#")
        channels = file.create_group("ch")
        channels.attrs["MATLAB_class"] = np.bytes_("struct")

        def put(key: str, value: np.ndarray, kind: str) -> h5py.Reference:
            held[key] = value
            held[key].attrs["MATLAB_class"] = np.bytes_(kind)
            if kind == "char":
                held[key].attrs["MATLAB_int_decode"] = 2
            return held[key].ref

        letters = lambda w: np.array([[ord(c)] for c in w], "u2")  # noqa: E731
        fields = {"name": [], "unit": [], "fs": [], "data": []}
        for k, (n, u, row) in enumerate(zip(NAMES, UNITS, r.rows, strict=True)):
            fields["name"].append(put(f"n{k}", letters(n), "char"))
            fields["unit"].append(put(f"u{k}", letters(u), "char"))
            fields["fs"].append(put(f"f{k}", np.array([[d.rate]]), "double"))
            fields["data"].append(put(f"d{k}", row[None, :], "double"))
        for key, refs in fields.items():
            channels.create_dataset(key, data=np.array([[x] for x in refs], dtype=h5py.ref_dtype), dtype=h5py.ref_dtype)
    block = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Sun Mar 29 10:00:00 2026 HDF5 schema 1.00 ."
    with (folder / "case.mat").open("r+b") as out:
        out.write(block.ljust(116) + b"\0" * 8 + struct.pack("<H", 0x0200) + b"IM")
    return Known(("case.mat",), (r,), rejected="(?i)map|variable|channel")


@draws("seventh")
def hdf5_counts_with_gain(folder: Path, d: Drawn) -> Known:
    """int16 datasets with attributes gain and offset, unit and dt: counts are not numbers of the unit."""
    r = d.hit()
    with h5py.File(folder / "case.h5", "w") as file:
        for name, unit, row in zip(NAMES, UNITS, r.rows, strict=True):
            gain = abs(row).max() / 32000
            file[name] = np.round(row / gain).astype("i2")
            file[name].attrs.update({"unit": np.bytes_(unit), "dt": 1 / d.rate, "gain": gain, "offset": 0.0})
    return Known(("case.h5",), (r,), tolerance=3e-5, rejected="(?i)gain|whole|count|scale")


@draws("seventh")
def hdf5_nan_block(folder: Path, d: Drawn) -> Known:
    """HDF5 (samples, channels) with a block of NaN in one of two responses."""
    rows = d.hit().rows.copy()
    rows[2, 700:732] = np.nan
    with h5py.File(folder / "case.h5", "w") as file:
        for name, row in zip(NAMES, rows, strict=True):
            file[name] = row
            file[name].attrs["fs"] = d.rate
    return Known(("case.h5",), rejected="(?i)a2.*nan|nan.*a2|a2.*missing|missing.*a2")


@draws("seventh")
def velocities_of_a_laser(folder: Path, d: Drawn) -> Known:
    """Records of velocity in mm/s in a universal file, the rig says m/s."""
    r = d.hit(derivatives=1)
    sets = functions(Record(r.force, r.a1 * 1e3, r.a2 * 1e3, r.rate), ("N", "mm/s", "mm/s"), double=True)
    sets = [s if k == 0 else Function(**{**s.__dict__, "ordinate": (MOVING, "mm/s")}) for k, s in enumerate(sets)]
    return Known(save_uff(folder, text_58(sets)), (r,), rig=VELOCITY)


@draws("seventh")
def uff_receptance_drafted(folder: Path, d: Drawn) -> Known:
    """Receptances in single precision and mm/N, no rig."""
    right = d.frf("receptance")
    scaled_up = KnownFrf(right.frequency, right.values * 1e3, "receptance")
    return Known(save_uff(folder, text_58(frfs(scaled_up, DISPLACEMENT, "mm"))), check=modes(d), rig=None, options=())
