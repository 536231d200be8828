"""A tenth draw, binary and universal files: number forms, kinds of modes, and transforms with their mirror."""

import json
import struct
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import save as save_array
from array_cases import wave
from drawn import Drawn, draws
from known import RATE, VOLTS, Known, KnownFrf
from seventh_cases import frfs, functions, waved
from seventh_table_cases import at, slow
from tdms_cases import A1, A2, FORCE, thing
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from tenth_cases import DRIVEN
from uff_written import Function, binary_58, nodes_2411, shapes_55, text_58
from uff_written import save as save_uff

GENERAL = 1


@draws("tenth")
def uff_magnitudes(folder: Path, d: Drawn) -> Known:
    """FRFs of real numbers: magnitudes without phases, which no modes follow from."""
    magnitudes = KnownFrf(d.lines, abs(d.frf().values))
    return Known(save_uff(folder, text_58(frfs(magnitudes))), rejected="(?i)real|magnitude|phase|complex")


@draws("tenth")
def uff_general_quantity(folder: Path, d: Drawn) -> Known:
    """Ordinates of the general kind, their units in the label alone."""
    r = d.hit()
    units = ((GENERAL, "N"), (GENERAL, "m/s^2"), (GENERAL, "m/s^2"))
    written = [
        Function(f.values, f.step, response=f.response, ordinate=unit, double=True)
        for f, unit in zip(functions(r), units, strict=True)
    ]
    return Known(save_uff(folder, text_58(written)), (r,))


@draws("tenth")
def uff_hits_by_sequence(folder: Path, d: Drawn) -> Known:
    """Two hits that differ in the version number alone: both forces, then both first responses, and so on."""
    hits = [d.hit(1), d.hit(2)]
    lines = []
    for pair in zip(*(functions(r, double=True) for r in hits), strict=True):
        for number, function in enumerate(pair, 1):
            rows = text_58([function])
            rows[7] = rows[7][:15] + f"{number:5d}" + rows[7][20:]
            lines += rows
    return Known(save_uff(folder, lines), tuple(hits))


def of_ibm(values: np.ndarray) -> bytes:
    """Hexadecimal floating point, single precision, big end first."""
    exponent = np.ceil(np.log2(np.maximum(abs(values), 1e-60)) / 4).astype(int)
    fraction = np.minimum(np.round(abs(values) / 16.0**exponent * 2**24), 2**24 - 1).astype("u4")
    return ((values < 0).astype("u4") << 31 | (exponent + 64).astype("u4") << 24 | fraction).astype(">u4").tobytes()


@draws("tenth")
def uff_binary_ibm(folder: Path, d: Drawn) -> Known:
    """Binary records of floating format 3, IBM 370."""
    r = d.hit()
    files = []
    for f in functions(r):
        data = binary_58(f, big=True)
        head, body = data[: -4 * len(f.values) - 8], of_ibm(f.values)
        files.append(head.replace(b"    58b     2     2", b"    58b     2     3") + body + b"\n    -1\n")
    return Known(save_uff(folder, b"".join(files)), (r,), rejected="(?i)IBM|floating|format 3")


@draws("tenth")
def uff_binary_and_text(folder: Path, d: Drawn) -> Known:
    """One FRF binary, the next as text."""
    right = d.frf()
    first, second = frfs(right, double=True)
    return Known(save_uff(folder, binary_58(first) + "\n".join([*text_58([second]), ""]).encode()), frf=right)


def shapes(d: Drawn, facts) -> list[str]:
    lines = nodes_2411([(1, 0.1, 0, 0), (2, 0.3, 0, 0)])
    for k, (f0, zeta, phi) in enumerate(d.modes, 1):
        lines += shapes_55(k, facts(f0, zeta), {n: (0, 0, v) for n, v in enumerate(phi, 1)})
    return lines


@draws("tenth")
def uff_forced_vibration(folder: Path, d: Drawn) -> Known:
    """Dataset 55 of analysis type 5, frequency response: deflections at lines, no modes."""
    lines = shapes(d, lambda f0, zeta: (f0, 1.0, zeta, 0.0))
    row = "".join(f"{v:10d}" for v in (1, 2, 2, 8, 2, 3))
    forced = [line.replace(row, row[:10] + f"{5:10d}" + row[20:]) for line in lines]

    def none(where: Path) -> str:
        found = json.loads((where / "out.json").read_text())["modes"]
        return f"modes: {found}" if found else ""

    return Known(save_uff(folder, forced), check=none, says="(are no|not) modes", rig=None, options=())


@draws("tenth")
def uff_hysteretic_damping(folder: Path, d: Drawn) -> Known:
    """Normal modes with viscous damping 0 and a hysteretic damping ratio, twice the equivalent viscous one."""
    lines = shapes(d, lambda f0, zeta: (f0, 1.0, 0.0, 2 * zeta))

    def right(where: Path) -> str:
        found = json.loads((where / "out.json").read_text())["modes"]
        values = [(m["frequency_hz"], m["damping_ratio"], m["shape"]["1"][2][0]) for m in found]
        wanted = [(f0, zeta, phi[0]) for f0, zeta, phi in d.modes]
        return "" if np.shape(values) == np.shape(wanted) and np.allclose(values, wanted, rtol=1e-3) else f"{found}"

    return Known(save_uff(folder, lines), check=right, rig=None, options=(), rejected="(?i)hysteretic|structural damp")


@draws("tenth")
def tdms_floats_with_unit(folder: Path, d: Drawn) -> Known:
    """Type 0x19, a single float with a unit, as LabVIEW writes numbers that carry one."""
    r = d.hit()
    rows = [row.astype("f4") for row in r.rows]
    objects = [thing("/"), thing("/'hit'")]
    for path, row, facts in zip((FORCE, A1, A2), rows, waved(d), strict=True):
        plain = struct.pack("<IIIQ", 20, 9, 1, len(row))
        objects.append(thing(path, row, facts).replace(plain, struct.pack("<IIIQ", 20, 0x19, 1, len(row))))
    return Known(save_tdms(folder, tdms_segment(objects, b"".join(row.tobytes() for row in rows))), (r,))


@draws("tenth")
def tdms_of_a_crash(folder: Path, d: Drawn) -> Known:
    """The program ended while writing: the last segment's length is all ones, its samples reach to the end."""
    r = d.hit()
    objects = [thing("/"), thing("/'hit'")]
    objects += [thing(p, row, f) for p, row, f in zip((FORCE, A1, A2), r.rows, waved(d), strict=True)]
    data = tdms_segment(objects, b"".join(row.tobytes() for row in r.rows))
    return Known(save_tdms(folder, data[:12] + b"\xff" * 8 + data[20:]), (r,), rejected="never finished")


def big_end_matrix(name: str, values: np.ndarray) -> bytes:
    """One miMATRIX of doubles, most significant byte first."""

    def element(kind: int, data: bytes) -> bytes:
        return struct.pack(">II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    body = element(6, struct.pack(">II", 6, 0)) + element(5, struct.pack(">ii", *values.shape))
    body += element(1, name.encode()) + element(9, values.astype(">f8").tobytes("F"))
    return struct.pack(">II", 14, len(body)) + body


@draws("tenth")
def matlab_big_end_first(folder: Path, d: Drawn) -> Known:
    """Level 5 as written on a machine whose most significant byte comes first: `MI` in the header."""
    r = d.hit()
    columns = {"time": r.time, "force": r.force, "a1": r.a1, "a2": r.a2}
    head = f"{'MATLAB 5.0 MAT-file, Platform: SOL2':<116s}".encode() + bytes(8) + struct.pack(">H", 0x0100) + b"MI"
    matrices = [big_end_matrix(name, values[:, None]) for name, values in columns.items()]
    return Known(save_array(folder, "case.mat", head + b"".join(matrices)), (r,))


@draws("tenth")
def matlab_whole_transform(folder: Path, d: Drawn) -> Known:
    """FRFs over all lines of fft, 0 to the rate: the upper half is the mirror of the lower."""
    half = d.frf(lines=np.arange(1, int(d.rate)) * 0.5)
    f = np.arange(2 * int(d.rate)) * 0.5
    h = np.array([np.r_[0, one, one[-1].real, one[::-1].conj()] for one in half.values])
    scipy.io.savemat(folder / "case.mat", {"f": f, "H": h})
    said = ("--variable", "frequency=f", "frf=H")
    reason = "(?i)mirror|two.sided|conjugate|half the rate|Nyquist"
    return Known(("case.mat",), frf=half, options=(*DRIVEN, *said), rejected=reason)


@draws("tenth")
def numpy_pickled(folder: Path, d: Drawn) -> Known:
    """A dictionary saved by numpy.save, which is a pickle: it could run anything."""
    r = d.hit()
    np.save(folder / "case.npy", {"time": r.time, "force": r.force, "a1": r.a1, "a2": r.a2}, allow_pickle=True)
    return Known(("case.npy",), rejected="(?i)pickle|object")


@draws("tenth")
def npz_dates(folder: Path, d: Drawn) -> Known:
    """Times as datetime64 of microseconds."""
    d = slow(d)
    r = d.hit()
    times = np.array([at(i, d.rate, "2026-11-28T23:59:59.5") for i in range(d.n)], "datetime64[us]")
    np.savez(folder / "case.npz", time=times, force=r.force, a1=r.a1, a2=r.a2)
    return Known(("case.npz",), (r,), rejected="(?i)datetime|time: .*date")


@draws("tenth")
def hdf5_complex(folder: Path, d: Drawn) -> Known:
    """FRFs as h5py writes complex numbers: pairs of r and i, (outputs, lines)."""
    right = d.frf()
    with h5py.File(folder / "case.h5", "w") as file:
        file["f"], file["H"] = right.frequency, right.values
    said = ("--variable", "frequency=f", "frf=H")
    return Known(("case.h5",), frf=right, options=(*DRIVEN, *said), rejected="(?i)map|axes|order")


@draws("tenth")
def wav_of_bytes(folder: Path, d: Drawn) -> Known:
    """8 bit, unsigned around 128, full scale 1 V."""
    d = Drawn(((60.0, 0.02, (0.6, 0.5)), (150.0, 0.02, (0.5, -0.8))), RATE, 2048, d.seed)
    r = d.hit()
    counts = np.round(r.rows.T * 0.004 * 128 + 128).clip(0, 255).astype("u1")
    rig = VOLTS.replace("0.01}", "0.004}")
    files = save_array(folder, "case.wav", wave(counts.tobytes(), 1, 8))
    return Known(files, (r,), rig=rig, options=(*DRIVEN, "--volts"), tolerance=0.05, check=lambda where: "")
