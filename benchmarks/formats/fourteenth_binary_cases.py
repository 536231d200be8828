"""A fourteenth draw, binary and universal files, after what programs and libraries of laboratories write."""

import struct
from pathlib import Path

import h5py
import numpy as np
import pyuff
import scipy.io
from array_cases import chunk
from array_cases import save as save_array
from drawn import Drawn, draws
from known import Known, KnownFrf
from seventh_cases import NAMES, UNITS, frfs, functions
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from tdms_cases import thing
from uff_written import ACCELERATION, FORCE, Function, header_151, text_58
from uff_written import save as save_uff


@draws("fourteenth")
def pulse_matlab(folder: Path, d: Drawn) -> Known:
    """PULSE to MATLAB: Channel_1_Data, Channel_1_Header with SignalName and Unit, File_Header with the rate as text."""
    r = d.hit()
    saved: dict = {
        "File_Header": {
            "NumberOfChannels": "3",
            "SampleFrequency": f"{d.rate:g}",
            "NumberOfSamplesPerChannel": f"{d.n}",
        }
    }
    for k, (n, u, row) in enumerate(zip(NAMES, UNITS, r.rows, strict=True), 1):
        saved |= {
            f"Channel_{k}_Data": row[:, None],
            f"Channel_{k}_Header": {"SignalName": n, "Unit": u, "MaxLevel": "100"},
        }
    scipy.io.savemat(folder / "case.mat", saved)
    return Known(("case.mat",), (r,), rejected="(?i)--map|--variable")


@draws("fourteenth")
def sdynpy_npz(folder: Path, d: Drawn) -> Known:
    """A structured array named data: abscissa, ordinate, comments and coordinates of each FRF; and function_type."""
    right = d.frf()
    n = len(right.frequency)
    fields = [("abscissa", "f8", (n,)), ("ordinate", "c16", (n,)), ("comment1", "<U80")]
    data = np.zeros((2, 1), [*fields, ("coordinate", [("node", "u8"), ("direction", "i1")], (2,))])
    data["abscissa"], data["ordinate"][:, 0] = right.frequency, right.values
    data["coordinate"]["node"][:, 0], data["coordinate"]["direction"] = [(1, 1), (2, 1)], 3
    np.savez(folder / "case.npz", data=data, function_type=np.array(4))
    return Known(("case.npz",), frf=right, rejected="(?i)--map|abscissa|fields|structur")


@draws("fourteenth")
def pyuff_written(folder: Path, d: Drawn) -> Known:
    """FRFs that pyuff wrote, with what it asks for and no more: nodes, directions, kinds, numbers."""
    right = d.frf()
    file = pyuff.UFF(str(folder / "case.uff"))
    for k, h in enumerate(right.values, 1):
        file.write_sets({"type": 58, "func_type": 4, "rsp_node": k, "rsp_dir": 3, "ref_node": 1, "ref_dir": 3,
                         "data": h, "x": right.frequency, "id1": "frf", "rsp_ent_name": "NONE", "ref_ent_name": "NONE",
                         "abscissa_spacing": 1, "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12,
                         "orddenom_spec_data_type": 13}, "overwrite" if k == 1 else "add")  # fmt: skip
    return Known(("case.uff",), frf=right)


@draws("fourteenth")
def wav_with_junk(folder: Path, d: Drawn) -> Known:
    """JUNK and bext before fmt, as recorders reserve space; cue and LIST behind the samples."""
    r = d.hit()
    data = r.rows.T.astype("<f4").tobytes()
    form = struct.pack("<HHIIHH", 3, 3, int(d.rate), int(d.rate) * 12, 12, 32)
    body = b"WAVE" + chunk(b"JUNK", bytes(28)) + chunk(b"bext", bytes(602)) + chunk(b"fmt ", form)
    body += chunk(b"fact", struct.pack("<I", d.n)) + chunk(b"data", data) + chunk(b"cue ", bytes(4))
    body += chunk(b"LIST", b"INFOICRD\x0a\0\0\x002026-11-26")
    return Known(save_array(folder, "case.wav", b"RIFF" + struct.pack("<I", len(body)) + body), (r,))


@draws("fourteenth")
def measurement_data_format(folder: Path, d: Drawn) -> Known:
    """ASAM MDF 4.10 by its first bytes."""
    data = b"MDF     4.10    modallab" + bytes(40) + b"##HD" + bytes(100) + d.hit().rows.tobytes()
    return Known(save_array(folder, "case.mf4", data), rejected="(?i)mdf|mf4|known|kind of file|format")


@draws("fourteenth")
def hdf5_sample_interval(folder: Path, d: Drawn) -> Known:
    """Datasets in nested groups, each with the attributes sample_interval in s and units."""
    r = d.hit()
    with h5py.File(folder / "case.h5", "w") as file:
        for name, unit, row in zip(NAMES, UNITS, r.rows, strict=True):
            place = file.create_dataset(f"run1/data/{name}", data=row)
            place.attrs["sample_interval"], place.attrs["units"] = 1 / d.rate, unit
    return Known(("case.h5",), (r,), rejected="(?i)--rate|--map|sample_interval")


@draws("fourteenth")
def uff_begins_with_words(folder: Path, d: Drawn) -> Known:
    """Records that begin 0.02 s before zero, all of them; text above the first -1."""
    r = d.hit()
    lines = text_58(functions(r, first=-0.02, double=True))
    return Known(save_uff(folder, ["exported by somebody", *header_151(), *lines], "\r\n"), (r,))


@draws("fourteenth")
def uff_dynamic_mass(folder: Path, d: Drawn) -> Known:
    """Force over acceleration: a dynamic mass, which is no inertance."""
    right = d.frf()
    mass = [Function(1 / h, 0.25, 0.25, 4, (k, 3), (1, 3), ordinate=(FORCE, "N"), denominator=(ACCELERATION, "m/s^2"))
            for k, h in enumerate(right.values, 1)]  # fmt: skip
    return Known(save_uff(folder, text_58(mass)), rejected="(?i)force|mass|inertance|N")


@draws("fourteenth")
def matlab_modalfrf(folder: Path, d: Drawn) -> Known:
    """[frf,f,coh] = modalfrf(...): lines by outputs, f as a column, coh beside."""
    right = d.frf()
    coherence = np.full(right.values.shape, 0.998)
    saved = {"frf": right.values.T, "f": right.frequency[:, None], "coh": coherence.T}
    scipy.io.savemat(folder / "case.mat", saved)
    known = KnownFrf(right.frequency, right.values, coherence=coherence)
    return Known(("case.mat",), frf=known, rejected="(?i)--map|axes")


@draws("fourteenth")
def tdms_rate_of_the_first(folder: Path, d: Drawn) -> Known:
    """wf_increment at the force only; the others have its length and nothing more."""
    r = d.hit()
    objects = [thing("/"), thing("/'hit'")]
    props = [{"unit_string": "N", "wf_increment": 1 / d.rate}, {"unit_string": "m/s^2"}, {"unit_string": "m/s^2"}]
    objects += [thing(f"/'hit'/'{n}'", row, p) for n, row, p in zip(NAMES, r.rows, props, strict=True)]
    files = save_tdms(folder, tdms_segment(objects, b"".join(row.tobytes() for row in r.rows)))
    return Known(files, (r,), rejected="(?i)wf_increment|--rate")


@draws("fourteenth")
def head_hdf(folder: Path, d: Drawn) -> Known:
    """HEAD acoustics' own .hdf: facts as text, `start of data`, then samples; no HDF5."""
    facts = ("start of data:       \t4096", "headerlen: 4096", "ch order: separate", "implementation type: int16", "")
    data = "\n".join(facts).encode().ljust(4096, b"\0") + d.hit().rows.astype("<i2").tobytes()
    return Known(save_array(folder, "case.hdf", data), rejected="(?i)head|hdf|known|kind of file|format|text")


@draws("fourteenth")
def uff_short_lines(folder: Path, d: Drawn) -> Known:
    """Blanks at the ends of lines left out, labels blank in place of NONE, and no dataset of units."""
    right = d.frf()
    lines = [line.replace("NONE", "    ").rstrip() for line in text_58(frfs(right, unit="NONE", double=True))]
    return Known(save_uff(folder, lines), frf=right)
