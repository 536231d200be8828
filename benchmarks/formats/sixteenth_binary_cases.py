"""A sixteenth draw, binary and universal files, after what programs of other fields write; the readers were known."""

import json
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import save as save_array
from drawn import Drawn, draws
from known import G, Known
from seventh_cases import NAMES, UNITS, frfs
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from tdms_cases import thing
from tenth_cases import DRIVEN
from uff_written import save as save_uff
from uff_written import text_58


@draws("sixteenth")
def lab_chart_matlab(folder: Path, d: Drawn) -> Known:
    """One row of all samples, datastart and dataend of each channel, titles, samplerate."""
    r = d.hit()
    begin = 1.0 + d.n * np.arange(3)[:, None]
    saved = {"data": r.rows.ravel()[None], "datastart": begin, "dataend": begin + d.n - 1, "titles": np.array(NAMES)}
    scipy.io.savemat(folder / "case.mat", saved | {"samplerate": np.full((3, 1), d.rate), "unittext": np.array(["N"])})
    return Known(("case.mat",), (r,), rejected="(?i)--map|--variable")


@draws("sixteenth")
def acq_knowledge_matlab(folder: Path, d: Drawn) -> Known:
    """data (samples, channels), isi in ms by isi_units, labels and units as padded characters."""
    r = d.hit()
    saved = {"data": r.rows.T, "isi": 1e3 / d.rate, "isi_units": "ms", "start_sample": 0.0}
    saved |= {"labels": np.array(["force", "a1   ", "a2   "]), "units": np.array(["N    ", "m/s^2", "m/s^2"])}
    scipy.io.savemat(folder / "case.mat", saved)
    return Known(("case.mat",), (r,), rejected="(?i)--rate|--map")


@draws("sixteenth")
def spike(folder: Path, d: Drawn) -> Known:
    """A structure a channel with title, comment, interval, scale 1, offset 0, units, start, length and values."""
    r = d.hit()
    saved = {}
    for n, u, row in zip(NAMES, UNITS, r.rows, strict=True):
        facts = {"title": n, "comment": "none", "interval": 1 / d.rate, "scale": 1.0, "offset": 0.0, "units": u}
        saved[n] = facts | {"start": 0.0, "length": float(d.n), "values": row[:, None]}
    scipy.io.savemat(folder / "case.mat", saved)
    return Known(("case.mat",), (r,), rejected="(?i)--rate|--map|interval")


@draws("sixteenth")
def hdf5_rate_at_the_root(folder: Path, d: Drawn) -> Known:
    """Datasets force, a1, a2 in single precision, and sample_rate_hz at the file; the force in kN by its attribute."""
    r = d.hit()
    with h5py.File(folder / "case.h5", "w") as file:
        file.attrs["sample_rate_hz"] = d.rate
        for n, u, row in zip(NAMES, ("kN", "m/s^2", "m/s^2"), r.rows, strict=True):
            file[n] = (row / (1e3 if u == "kN" else 1)).astype("f4")
            file[n].attrs["unit"] = u
    return Known(("case.h5",), (r,), rejected="(?i)--rate|--map")


@draws("sixteenth")
def npz_accelerations(folder: Path, d: Drawn) -> Known:
    """time, force, and accel (channels, samples), whose rows are said."""
    r = d.hit()
    np.savez(folder / "case.npz", time=r.time, force=r.force, accel=np.array([r.a1, r.a2]))
    said = ("--variable", "a1=accel:1", "a2=accel:2")
    return Known(("case.npz",), (r,), options=(*DRIVEN, *said))


@draws("sixteenth")
def tdms_of_iepe(folder: Path, d: Drawn) -> Known:
    """unit_string g and NI_UnitDescription Gravity, NI_ChannelName cDAQ1Mod1/ai1; a start time of the file."""
    r = d.hit()
    rows = (r.force, r.a1 / G, r.a2 / G)
    objects = [thing("/", None, {"name": "log", "Operator": "somebody"}), thing("/'Log'")]
    for k, (n, u, row) in enumerate(zip(NAMES, ("N", "g", "g"), rows, strict=True)):
        props = {"unit_string": u, "NI_UnitDescription": "Newtons" if u == "N" else "Gravity"}
        props |= {"NI_ChannelName": f"cDAQ1Mod1/ai{k}", "wf_increment": 1 / d.rate, "wf_samples": d.n}
        objects.append(thing(f"/'Log'/'{n}'", row, props))
    return Known(save_tdms(folder, tdms_segment(objects, b"".join(row.tobytes() for row in rows))), (r,))


@draws("sixteenth")
def uff_units_that_differ(folder: Path, d: Drawn) -> Known:
    """The first FRF in m/s^2 per N, the second in g per N."""
    right = d.frf()
    first, second = frfs(right, double=True)
    other = frfs(type(right)(right.frequency, right.values / G), unit="g", double=True)[1]
    assert second.response == other.response
    return Known(save_uff(folder, text_58([first, other])), frf=right)


@draws("sixteenth")
def wave_of_64_bits(folder: Path, d: Drawn) -> Known:
    """Sony's Wave64: begins with riff and a GUID."""
    data = b"riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb\x04\xc1\x00\x00" + bytes(104) + d.hit().rows.tobytes()
    return Known(save_array(folder, "case.w64", data), rejected="(?i)known|wav")


@draws("sixteenth")
def lossless_audio(folder: Path, d: Drawn) -> Known:
    """FLAC by its first bytes."""
    data = b"fLaC\x00\x00\x00\x22" + bytes(34) + d.hit().rows.tobytes()
    return Known(save_array(folder, "case.flac", data), rejected="(?i)known|flac")


@draws("sixteenth")
def sep_of_two_zones(folder: Path, d: Drawn) -> Known:
    """One moment in two zones: 10:00:00.000Z and 11:00:00.000+01:00."""
    r = d.hit()
    stamps = ("2026-11-26T10:00:00.000Z", "2026-11-26T10:00:00.000Z", "2026-11-26T11:00:00.000+01:00")
    series = [{"name": n, "unit_str": u, "fs": d.rate, "start_timestamp": s, "data": row.tolist()}
              for n, u, s, row in zip(NAMES, UNITS, stamps, r.rows, strict=True)]  # fmt: skip
    (folder / "case.json").write_text(json.dumps(series), encoding="utf-8")
    return Known(("case.json",), (r,))


@draws("sixteenth")
def remote_parameter_control(folder: Path, d: Drawn) -> Known:
    """RPC III: keys and values of 32 and 96 bytes, then whole numbers; no format of this program."""
    facts = {"FORMAT": "BINARY", "NUM_HEADER_BLOCKS": "2", "NUM_PARAMS": "12", "FILE_TYPE": "TIME_HISTORY"}
    top = b"".join(k.encode().ljust(32, b"\0") + v.encode().ljust(96, b"\0") for k, v in facts.items())
    data = top.ljust(1024, b"\0") + d.hit().rows.astype("<i2").tobytes()
    return Known(save_array(folder, "case.rsp", data), rejected="(?i)known|kind of file|rpc")


@draws("sixteenth")
def npy_of_counts(folder: Path, d: Drawn) -> Known:
    """A structured array with times and whole numbers of a converter, whose scale nothing says."""
    r = d.hit()
    data = np.zeros(d.n, [("time", "f8"), *((n, "i2") for n in NAMES)])
    data["time"] = r.time
    for n, row in zip(NAMES, r.rows, strict=True):
        data[n] = np.round(100 * row).clip(-32000, 32000)
    np.save(folder / "case.npy", data)
    return Known(("case.npy",), rejected="(?i)whole numbers|scale|int16|counts")
