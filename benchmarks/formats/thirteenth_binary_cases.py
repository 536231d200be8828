"""A thirteenth draw, binary and universal files, after what programs of laboratories write."""

from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import save as save_array
from drawn import Drawn, draws
from known import Known
from seventh_cases import NAMES, UNITS, frfs, functions
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from tdms_cases import thing
from tenth_cases import DRIVEN
from uff_written import EDGE, Function, function_head, numbers, text_58
from uff_written import save as save_uff


@draws("thirteenth")
def catman_uff(folder: Path, d: Drawn) -> Known:
    """catman: exponents of three digits, node 0, names in the first line (`force : N`) and in the ordinate's label."""
    r = d.hit()
    lines = []
    for name, unit, row in zip(NAMES, ("N", "m/s²", "m/s²"), r.rows, strict=True):
        top = function_head(Function(row, 1 / d.rate, response=(0, 0), ordinate=(1, unit), double=True))
        top[0], top[1] = f"{name} : {unit}", "UFF58 file created by HBM catman"
        top[5] = f"{1:5d}{0:10d}{0:5d}{0:10d} NONE      {0:10d}{0:4d} NONE      {0:10d}{0:4d}"
        top[6] = f"{4:10d}{d.n:10d}{1:10d} 0.00000E+000 {1 / d.rate:.5E} 0.00000E+000".replace("E-0", "E-00")
        top[8] = f"{1:10d}{0:5d}{0:5d}{0:5d} {name:<20.20s} {unit:<20.20s}"
        lines += [EDGE, "    58", *top, *numbers(Function(row, 1 / d.rate, double=True)), EDGE]
    files = save_uff(folder, ("\n".join(lines) + "\n").encode("cp1252"))
    return Known(files, (r,), rejected="(?i)0\\.00000E\\+000|which channel|no channel|name")


@draws("thirteenth")
def oros_ratio(folder: Path, d: Drawn) -> Known:
    """Nodes 0, channels only in the fifth line `H1 : #  2 / #  1`, the unit `(1/N)*(m/s²)`."""
    right = d.frf()
    lines = []
    for k, h in enumerate(right.values, 2):
        top = function_head(Function(h, 0.25, 0.25, 4, (0, 0), ordinate=(1, "(1/N)*(m/s²)"), double=True))
        top[4] = f"H1 : # {k:2d} / #  1"
        lines += [EDGE, "    58", *top, *numbers(Function(h, 0.25, double=True)), EDGE]
    files = save_uff(folder, ("\n".join(lines) + "\n").encode("cp1252"))
    return Known(files, frf=right, rejected="(?i)node|name|channel|which|unit")


@draws("thirteenth")
def pulse_uff(folder: Path, d: Drawn) -> Known:
    """PULSE: FRFs with entities `a1` and `Hammer`, coherences beside, a title in the first line."""
    right = d.frf()
    lines = []
    for k, f in enumerate(frfs(right, unit="m/s²", double=True), 1):
        top = function_head(f)
        top[0] = f"Frequency Response H1(a{k},Hammer) - Input"
        top[5] = f"{4:5d}{0:10d}{0:5d}{0:10d} {f'a{k}':<10s}{k:10d}{3:4d} {'Hammer':<10s}{1:10d}{3:4d}"
        lines += [EDGE, "    58", *top, *numbers(f), EDGE]
    return Known(save_uff(folder, ("\r\n".join(lines) + "\r\n").encode("cp1252")), frf=right)


@draws("thirteenth")
def testlab_1858(folder: Path, d: Drawn) -> Known:
    """Testlab writes a dataset 1858 of facts before each 58."""
    r = d.hit()
    facts = [EDGE, "  1858", *6 * ["         1         0         0         0         0         0"], *2 * ["NONE"], EDGE]
    lines = [line for f in functions(r, double=True) for line in (*facts, *text_58([f]))]
    return Known(save_uff(folder, lines, "\r\n"), (r,))


@draws("thirteenth")
def flexlogger_modules(folder: Path, d: Drawn) -> Known:
    """Groups Mod1 with the force and Mod2 with the responses at one rate; a third group of events without numbers."""
    r = d.hit()
    wave = {"wf_increment": 1 / d.rate, "wf_start_offset": 0.0, "wf_samples": d.n}
    objects = [thing("/", None, {"name": "log", "author": "somebody"}), thing("/'Mod1'"), thing("/'Mod2'")]
    objects += [thing("/'Events'"), thing("/'Events'/'text'")]
    places = ("/'Mod1'/'force'", "/'Mod2'/'a1'", "/'Mod2'/'a2'")
    objects += [thing(p, row, {"unit_string": u, **wave}) for p, row, u in zip(places, r.rows, UNITS, strict=True)]
    return Known(save_tdms(folder, tdms_segment(objects, b"".join(row.tobytes() for row in r.rows))), (r,))


@draws("thirteenth")
def dewesoft_matlab(folder: Path, d: Drawn) -> Known:
    """Data1_force, Data1_time_force ..., Sample_rate, Start_time, File_name."""
    r = d.hit()
    saved = {f"Data1_{n}": row[:, None].astype("f4") for n, row in zip(NAMES, r.rows, strict=True)}
    saved |= {f"Data1_time_{n}": r.time[:, None] for n in NAMES} | {"Sample_rate": d.rate, "File_name": "hit.dxd"}
    scipy.io.savemat(folder / "case.mat", saved | {"Start_time": "26-Nov-2026 10:00:00"})
    said = ("--variable", *(f"{n}=Data1_{n}" for n in NAMES))
    return Known(("case.mat",), (r,), options=(*DRIVEN, *said), rejected="(?i)--map|rate")


@draws("thirteenth")
def abravibe(folder: Path, d: Drawn) -> Known:
    """Data, a cell of columns, and Header, an array of structures with xIncrement, Label and Unit."""
    r = d.hit()
    data, header = np.empty(3, object), np.empty(3, object)
    for k, (n, u, row) in enumerate(zip(NAMES, UNITS, r.rows, strict=True)):
        data[k] = row[:, None]
        header[k] = {"FunctionType": 1, "NoValues": d.n, "xStart": 0.0, "xIncrement": 1 / d.rate, "Label": n, "Unit": u}
    scipy.io.savemat(folder / "case.mat", {"Data": data, "Header": header})
    return Known(("case.mat",), (r,), rejected="(?i)--map")


@draws("thirteenth")
def rattlesnake(folder: Path, d: Drawn) -> Known:
    """netCDF4: time_data (channels, samples), sample_rate of the file, a group of the channels; said by a map."""
    r = d.hit()
    with h5py.File(folder / "case.nc4", "w") as file:
        file.attrs["sample_rate"], file.attrs["time_per_write"] = d.rate, 0.25
        file["time_data"] = r.rows
        for name, values in {"node_number": ("1", "1", "2"), "node_direction": ("Z+",) * 3, "unit": UNITS}.items():
            file[f"channels/{name}"] = np.array(values, object)
    said = f"rate_hz: {d.rate}\nforce: 'time_data:1'\nresponses: {{a1: 'time_data:2', a2: 'time_data:3'}}\n"
    (folder / "map.yaml").write_text(said + "response_unit: m/s^2\nforce_unit: N\n", encoding="utf-8")
    return Known(("case.nc4",), (r,), options=(*DRIVEN, "--map", "map.yaml"))


@draws("thirteenth")
def numpy_exc_resp(folder: Path, d: Drawn) -> Known:
    """numpy.savez of exc, resp (samples, outputs) and fs; said by a map, accelerations in g."""
    r = d.hit()
    np.savez(folder / "case.npz", exc=r.force, resp=np.array([r.a1, r.a2]).T / 9.80665, fs=d.rate)
    said = "rate_hz: fs\nforce: exc\nresponses: resp\naxes: [samples, outputs]\noutputs: [1, 2]\nresponse_unit: g\n"
    (folder / "map.yaml").write_text(said + "force_unit: N\n", encoding="utf-8")
    return Known(("case.npz",), (r,), options=(*DRIVEN, "--map", "map.yaml"))


@draws("thirteenth")
def imc_raw(folder: Path, d: Drawn) -> Known:
    """imc's binary file of blocks |CF, |CK ... |CS: it is no format of this program."""
    rows = d.hit().rows.astype("f4")
    top = b"|CF,2,1,1;|CK,1,3,1,1;|NO,1,86,0,78,imc STUDIO 5.0 R10 (04.08.2017),0,;\r\n|CG,1,5,1,1,1;"
    data = top + f"|CD,2,63,{1 / d.rate:.16E},1,1,s,0,0,0,0.0,1;|CS,1,{rows.nbytes + 2},1,".encode() + rows.tobytes()
    return Known(save_array(folder, "case.raw", data + b";"), rejected="(?i)imc|famos|format|known|kind of file")
