"""WAV, NPY, MATLAB and foreign HDF5 files."""

import struct
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from known import RATE, VOLTS, G, Known, KnownFrf, case, hit, inertance, moved

EXTENSIBLE = 0xFFFE
GUID = bytes.fromhex("000000001000800000aa00389b71")


def chunk(name: bytes, data: bytes, size: int | None = None) -> bytes:
    return name + struct.pack("<I", len(data) if size is None else size) + data + b"\0" * (len(data) % 2)


def wave(
    data: bytes, kind: int, bits: int, before: bytes = b"", extensible: bool = False, size: int | None = None
) -> bytes:
    step = 3 * bits // 8
    form = struct.pack("<HHIIHH", EXTENSIBLE if extensible else kind, 3, int(RATE), int(RATE) * step, step, bits)
    form += struct.pack("<HHI", 22, bits, 7) + struct.pack("<H", kind) + GUID if extensible else b""
    body = b"WAVE" + chunk(b"fmt ", form) + before + chunk(b"data", data, size)
    return b"RIFF" + struct.pack("<I", len(body) if size is None else 0xFFFFFFFF) + body


def save(folder: Path, name: str, data: bytes) -> tuple[str, ...]:
    (folder / name).write_bytes(data)
    return (name,)


@case("wav")
def wav_float(folder: Path) -> Known:
    """Floats in the unit of the rig; a list of odd length and a fact chunk before the samples."""
    record = hit()
    before = chunk(b"fact", struct.pack("<I", 1024)) + chunk(b"LIST", b"INFOISFT\x05\0\0\0abcde")
    return Known(save(folder, "case.wav", wave(record.rows.T.astype("<f4").tobytes(), 3, 32, before)), (record,))


@case("wav")
def wav_double_extensible(folder: Path) -> Known:
    """Doubles, extensible format."""
    record = hit()
    return Known(
        save(folder, "case.wav", wave(record.rows.T.astype("<f8").tobytes(), 3, 64, extensible=True)), (record,)
    )


@case("wav")
def wav_24_bit(folder: Path) -> Known:
    """24 bit counts: full scale is 1, which is 1 V with --volts."""
    record = hit()
    volts = record.rows * 0.01
    volts[0] *= 0.5
    top = np.abs(volts).max() * 1.01
    volts, rig = (
        volts / top,
        VOLTS.replace("0.01", f"{0.01 / top:.9f}").replace(f"{0.01 / top:.9f}", f"{0.005 / top:.9f}", 1),
    )
    counts = np.round(volts.T * 2**23).astype("<i4").reshape(-1, 1).view(np.uint8)[:, :3]
    data = wave(counts.tobytes(), 1, 24, extensible=True)
    return Known(save(folder, "case.wav", data), (record,), rig=rig, options=("--drive-point", "1", "--volts"))


@case("wav")
def wav_streamed(folder: Path) -> Known:
    """A stream's length of 0xFFFFFFFF: nobody went back to write it."""
    record = hit()
    data = wave(record.rows.T.astype("<f4").tobytes(), 3, 32, size=0xFFFFFFFF)
    return Known(save(folder, "case.wav", data), (record,), rejected="(?i)length|cut|long|bytes|samples")


@case("wav")
def wav_cut(folder: Path) -> Known:
    """Half of the samples are missing."""
    data = wave(hit().rows.T.astype("<f4").tobytes(), 3, 32)
    return Known(save(folder, "case.wav", data[: len(data) // 2]), rejected="(?i)cut|long|bytes|samples|end")


@case("wav")
def wav_two_channels(folder: Path) -> Known:
    """More channels than the rig names."""
    rig = VOLTS.split("- {index: 2")[0]
    data = wave(hit().rows.T.astype("<f4").tobytes(), 3, 32)
    return Known(save(folder, "case.wav", data), rig=rig, rejected=r"(?is)3.*channel.*2|2.*channel.*3")


@case("npy")
def npy_big_endian_fortran(folder: Path) -> Known:
    """Big-endian float32, columns first in memory, times in the first row."""
    record = hit()
    rows = np.asfortranarray(np.vstack([record.time, record.rows]).astype(">f8"))
    np.save(folder / "case.npy", rows)
    return Known(("case.npy",), (record,))


@case("npy")
def npy_zipped(folder: Path) -> Known:
    """Several arrays in one .npz."""
    record = hit()
    np.savez(folder / "case.npz", time=record.time, data=record.rows)
    return Known(("case.npz",), (record,), rejected="(?i)npz|zip|several|archive")


@case("matlab")
def mat_structures(folder: Path) -> Known:
    """A structure a channel, with data, sample rate and a start of its own."""
    rows, right = moved(hit(), (0, 6, 2))
    names = ("force", "a1", "a2")
    parts = {
        n: {"data": r[:, None], "fs": RATE, "t0": k / RATE} for n, r, k in zip(names, rows, (0, 6, 2), strict=True)
    }
    scipy.io.savemat(folder / "case.mat", parts)
    return Known(("case.mat",), (right,))


@case("matlab")
def mat_level_4(folder: Path) -> Known:
    """MATLAB's version 4, as old programs and Octave's -v4 write it."""
    record = hit()
    content = {"force": record.force, "a1": record.a1, "a2": record.a2, "fs": RATE}
    scipy.io.savemat(folder / "case.mat", content, format="4")
    return Known(("case.mat",), (record,), rejected="(?i)version 4|level 4|v4")


@case("matlab")
def mat_compressed_single(folder: Path) -> Known:
    """Compressed, single precision, rows of times beside."""
    record = hit()
    content = {n: r.astype(np.float32)[None] for n, r in zip(("force", "a1", "a2"), record.rows, strict=True)}
    scipy.io.savemat(folder / "case.mat", content | {"t": record.time[:, None]}, do_compression=True)
    return Known(("case.mat",), (record,))


@case("matlab")
def mat_73_structure(folder: Path) -> Known:
    """Version 7.3: a structure with fields, arrays transposed as MATLAB stores them."""
    record = hit()
    with h5py.File(folder / "body.h5", "w", userblock_size=512) as file:
        group = file.create_group("meas")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, row in zip(("force", "a1", "a2", "time"), [*record.rows, record.time], strict=True):
            group[name] = row[None]
            group[name].attrs["MATLAB_class"] = np.bytes_("double")
    return Known(save(folder, "case.mat", with_user_block(folder / "body.h5")), (record,))


def with_user_block(body: Path) -> bytes:
    title = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Sun Mar 29 10:00:00 2026 HDF5 schema 1.00 ."
    data = body.read_bytes()
    body.unlink()
    return title.ljust(116) + b" " * 8 + struct.pack("<H", 0x0200) + b"IM" + data[128:]


@case("matlab")
def mat_mapped_frfs(folder: Path) -> Known:
    """FRFs (inputs, lines, outputs) in single precision, lines in rad/s, by a map, g/N."""
    lines = np.arange(20.0, 220.0, 0.5)
    right = inertance(lines)[:, 0]
    scipy.io.savemat(
        folder / "case.mat", {"D": {"H": (right.T[None] / G).astype(np.complex64), "w": 2 * np.pi * lines}}
    )
    rows = ["frf: D.H", "frequency: D.w", "frequency_unit: rad/s", "axes: [inputs, lines, outputs]", "unit: g/N"]
    (folder / "map.yaml").write_text("\n".join([*rows, "outputs: [a1, a2]", "inputs: [1]"]) + "\n", encoding="utf-8")
    return Known(("case.mat",), frf=KnownFrf(lines, right), options=("--map", "map.yaml"))


@case("matlab")
def mat_deep_structure(folder: Path) -> Known:
    """Structures in structures, as test systems export: Signal.y_values.values."""
    record = hit()
    parts = {
        f"Signal_{k}": {"x_values": {"start_value": 0.0, "increment": 1 / RATE}, "y_values": {"values": r[:, None]}}
        for k, r in enumerate(record.rows)
    }
    scipy.io.savemat(folder / "case.mat", parts)
    ours = ["rate_hz: 2000", "force: Signal_0.y_values.values"]
    ours += ["responses: {a1: Signal_1.y_values.values, a2: Signal_2.y_values.values}"]
    (folder / "map.yaml").write_text("\n".join(ours) + "\n", encoding="utf-8")
    return Known(("case.mat",), (record,), options=("--map", "map.yaml", "--drive-point", "1"))


@case("matlab")
def mat_records_in_one_array(folder: Path) -> Known:
    """Two hits in one array (outputs, samples, records), in g, by a map."""
    one, two = hit(1), hit(2)
    acc = np.stack([[r.a1, r.a2] for r in (one, two)], axis=-1) / G
    scipy.io.savemat(folder / "case.mat", {"t": one.time, "F": np.stack([one.force, two.force], axis=-1), "acc": acc})
    rows = [
        "time: t",
        "force: F",
        "responses: acc",
        "axes: [outputs, samples, records]",
        "response_unit: g",
        "outputs: [a1, a2]",
    ]
    (folder / "map.yaml").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return Known(("case.mat",), (one, two), options=("--map", "map.yaml", "--drive-point", "1"))


@case("hdf5")
def foreign_hdf5(folder: Path) -> Known:
    """HDF5 of another program: its arrays have no rule that says what is what."""
    with h5py.File(folder / "case.h5", "w") as file:
        file["measurement/data"] = hit().rows
    return Known(("case.h5",), rejected="(?i)times nor a rate")
