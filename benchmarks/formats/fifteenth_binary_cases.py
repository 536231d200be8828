"""A fifteenth draw, binary and universal files, drawn with the fourteenth."""

import io
import zipfile
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import save as save_array
from array_cases import wave
from drawn import Drawn, draws
from known import PLAIN, Known
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from seventh_cases import NAMES, UNITS, frfs
from seventh_table_cases import rows_of
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from tdms_cases import thing
from tenth_cases import DRIVEN, HEAD
from uff_written import save as save_uff
from uff_written import text_58, units_164

VOLTS = PLAIN.replace(", point", ", sensitivity_v_per_unit: 0.01, point")


@draws("fifteenth")
def picoscope_matlab(folder: Path, d: Drawn) -> Known:
    """Tstart, Tinterval, Length, RequestedLength, Version, and A, B, C in V, single precision."""
    r = d.hit()
    rows = (0.01 * r.rows).astype("f4")
    saved = {"Tstart": -0.02, "Tinterval": 1 / d.rate, "ExtraSamples": 0.0, "RequestedLength": float(d.n)}
    saved |= {"Length": float(d.n), "Version": "6.14"} | {n: row[:, None] for n, row in zip("ABC", rows, strict=True)}
    scipy.io.savemat(folder / "case.mat", saved)
    said = ("--variable", "force=A", "a1=B", "a2=C", "--volts")
    return Known(("case.mat",), (r,), options=(*DRIVEN, *said), rig=VOLTS, rejected="(?i)Tinterval|rate|--map|Length")


@draws("fifteenth")
def structural_dynamics_toolbox(folder: Path, d: Drawn) -> Known:
    """XF.w in Hz, XF.xf a column an FRF, XF.dof and labels; said by a map."""
    right = d.frf()
    dof = np.array([[1.03, 1.03], [2.03, 1.03]])
    scipy.io.savemat(folder / "case.mat", {"XF": {"w": right.frequency[:, None], "xf": right.values.T, "dof": dof}})
    said = "frf: XF.xf\nfrequency: XF.w\naxes: [lines, outputs]\nunit: m/s^2/N\noutputs: [1, 2]\ninputs: [1]\n"
    (folder / "map.yaml").write_text(said, encoding="utf-8")
    return Known(("case.mat",), frf=right, options=("--map", "map.yaml"))


@draws("fifteenth")
def nptdms_written(folder: Path, d: Drawn) -> Known:
    """npTDMS: a root with properties, a group, channels in two segments with wf_start_time as datetime64."""
    r = d.hit()
    start = np.datetime64("2026-11-26T10:00:00.250")
    half = d.n // 2
    with TdmsWriter(str(folder / "case.tdms")) as file:
        for part in (slice(0, half), slice(half, None)):
            objects = [RootObject({"title": "a hit"}), GroupObject("hit", {"operator": "somebody"})]
            for n, u, row in zip(NAMES, UNITS, r.rows, strict=True):
                props = {"unit_string": u, "wf_increment": 1 / d.rate, "wf_start_time": start, "wf_start_offset": 0.0}
                objects.append(ChannelObject("hit", n, row[part], props))
            file.write_segment(objects)
    return Known(("case.tdms",), (r,))


@draws("fifteenth")
def wav_a_file_a_channel(folder: Path, d: Drawn) -> Known:
    """A recorder's three mono files of one record."""
    r = d.hit()
    files = []
    for name, row in zip(NAMES, r.rows, strict=True):
        data = wave(row.astype("<f4").tobytes(), 3, 32)
        data = data.replace((3).to_bytes(2, "little") + (3).to_bytes(2, "little"), b"\x03\0\x01\0", 1)
        step = int(d.rate) * 4
        at = data.index(b"fmt ") + 12
        data = data[:at] + int(d.rate).to_bytes(4, "little") + step.to_bytes(4, "little") + b"\x04\0" + data[at + 10 :]
        files += save_array(folder, f"{name}.wav", data)
    return Known(tuple(files), (r,), rejected="(?i)channel")


@draws("fifteenth")
def arrow_file(folder: Path, d: Drawn) -> Known:
    """An Arrow or Feather file by its first and last bytes."""
    data = b"ARROW1\0\0" + d.hit().rows.tobytes() + b"ARROW1"
    return Known(save_array(folder, "case.feather", data), rejected="(?i)arrow|feather|known|kind of file|format")


@draws("fifteenth")
def rattlesnake_without_map(folder: Path, d: Drawn) -> Known:
    """Rattlesnake's netCDF4: time_data, sample_rate, and a group of the channels with their facts."""
    r = d.hit()
    with h5py.File(folder / "case.nc4", "w") as file:
        file.attrs["sample_rate"], file.attrs["time_per_write"] = d.rate, 0.25
        file["time_data"] = r.rows
        facts = {"node_number": ("1", "1", "2"), "node_direction": ("Z+",) * 3, "unit": UNITS, "comment": NAMES}
        facts["channel_type"] = ("Force", "Acceleration", "Acceleration")
        for name, values in facts.items():
            file[f"channels/{name}"] = np.array(values, object)
    return Known(("case.nc4",), (r,), rejected="(?i)--map|--variable|channels")


@draws("fifteenth")
def uff_kilograms_force(folder: Path, d: Drawn) -> Known:
    """Dataset 164 of mm and kilograms of force, labels blank: FRFs in (mm/s²)/kgf."""
    right = d.frf()
    scaled = type(right)(right.frequency, right.values * 1e3 * 9.80665)
    system = (8, "GM: mm (kilogram f)", 1000.0, 1 / 9.80665)
    return Known(
        save_uff(folder, [*units_164(system), *text_58(frfs(scaled, unit=" ", denominator=(13, " "), double=True))]),
        frf=right,
    )


@draws("fifteenth")
def uff_rotation(folder: Path, d: Drawn) -> Known:
    """The second response is an angular acceleration about z: direction 6, which the rig has no channel for."""
    right = d.frf()
    lines = text_58(frfs(right, nodes=((1, 3), (2, 6)), double=True))
    return Known(save_uff(folder, lines), rejected="(?i)direction|rotat|a2|node")


@draws("fifteenth")
def npz_columns(folder: Path, d: Drawn) -> Known:
    """t and x, whose columns are the force and the responses, said by a map."""
    r = d.hit()
    np.savez_compressed(folder / "case.npz", t=r.time, x=r.rows.T)
    said = "time: t\nforce: 'x:1'\nresponses: {a1: 'x:2', a2: 'x:3'}\nforce_unit: N\nresponse_unit: m/s^2\n"
    (folder / "map.yaml").write_text(said, encoding="utf-8")
    return Known(("case.npz",), (r,), options=(*DRIVEN, "--map", "map.yaml"))


@draws("fifteenth")
def tdms_time_channel(folder: Path, d: Drawn) -> Known:
    """DIAdem's group: Time in ms by its unit_string, then the channels, no wf_increment."""
    r = d.hit()
    objects = [thing("/"), thing("/'hit'"), thing("/'hit'/'Time'", 1e3 * r.time, {"unit_string": "ms"})]
    units = [{"unit_string": u} for u in UNITS]
    objects += [thing(f"/'hit'/'{n}'", row, u) for n, row, u in zip(NAMES, r.rows, units, strict=True)]
    raw = b"".join(row.tobytes() for row in (1e3 * r.time, *r.rows))
    return Known(save_tdms(folder, tdms_segment(objects, raw)), (r,))


@draws("fifteenth")
def compound_document(folder: Path, d: Drawn) -> Known:
    """A scan of a vibrometer, .svd, by its first bytes: a compound document."""
    data = bytes.fromhex("d0cf11e0a1b11ae1") + bytes(504) + d.hit().rows.tobytes()
    return Known(save_array(folder, "case.svd", data), rejected="(?i)known|kind of file|format|compound|svd")


@draws("fifteenth")
def zipped_table(folder: Path, d: Drawn) -> Known:
    """A telephone's archive with the table in it."""
    r = d.hit()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("hit/Data.csv", "\n".join([HEAD, *rows_of(r)]) + "\n")
    return Known(save_array(folder, "case.zip", packed.getvalue()), (r,), rejected="(?i)zip|unpack|archive|compress")
