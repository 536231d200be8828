"""A ninth draw, binary and universal files: starts within a sample, precise times, and arrays of other programs."""

import json
import struct
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import chunk
from drawn import Drawn, drawn, draws, identified, modes
from known import PLAIN, Known, Record, case
from seventh_cases import NAMES, UNITS, functions, waved
from tdms_cases import A1, A2, FORCE, thing
from tdms_cases import save as save_tdms
from tdms_cases import segment as tdms_segment
from uff_written import Function, header_151, nodes_2411, shapes_55, text_58
from uff_written import save as save_uff

from modallab.formats import read_campaign
from modallab.signals.signals import to_signals

DRIVEN = ("--drive-point", "1")


def between(name: str) -> tuple[Drawn, list[np.ndarray], Record]:
    """A structure, rows whose last begins half a sample later, and what is right had it begun with the others."""
    d = drawn(name)
    # Only what a converter's filter has left below half of the rate is known between its samples.
    spectra = np.fft.rfft(Drawn(d.modes, 2 * d.rate, 2 * d.n, d.seed).hit().rows, 4 * d.n)
    passed = np.clip(20 * (0.5 - np.linspace(0, 1, spectra.shape[1])), 0, 1)
    fine = np.fft.irfft(spectra * passed)[:, : 2 * d.n]
    right = Record(*fine[:, ::2], d.rate)
    return d, [right.force, right.a1, fine[2, 1::2]], right


def aligned(right: Record) -> Callable[[Path], str]:
    """Whether the second response lags the force as it should, within a fiftieth of a sample."""

    def lag(rows: np.ndarray) -> float:
        spectra = np.fft.rfft(rows[:, :1500], 4096)
        cross = spectra[-1] * spectra[0].conj()
        return float(np.angle(cross[40:400] * reference[40:400].conj()) @ weights)

    spectra = np.fft.rfft(right.rows[:, :1500], 4096)
    reference = spectra[-1] * spectra[0].conj()
    place = 2 * np.pi * np.arange(40, 400) / 4096 * abs(reference[40:400])
    weights = place * abs(reference[40:400]) / (place @ place)

    def check(folder: Path) -> str:
        campaign = read_campaign(folder / "out.h5")
        signals = to_signals(campaign.blocks[0], campaign.rig)
        off = lag(np.vstack([signals.forces[0], *signals.responses]))
        return "" if abs(off) < 0.02 else f"the second response is off by {off:.3f} samples"

    return check


def both(*checks: Callable[[Path], str]) -> Callable[[Path], str]:
    return lambda folder: next((said for one in checks if (said := one(folder))), "")


@case("ninth")
def tdms_half_a_sample(folder: Path) -> Known:
    """wf_start_offset of the last channel is half a sample."""
    d, rows, right = between("tdms_half_a_sample")
    facts = waved(d, wf_start_offset=0.0)
    facts[2] |= {"wf_start_offset": 0.5 / d.rate}
    objects = [thing("/"), thing("/'hit'")]
    objects += [thing(p, row.copy(), f) for p, row, f in zip((FORCE, A1, A2), rows, facts, strict=True)]
    data = tdms_segment(objects, b"".join(row.tobytes() for row in rows))
    return Known(save_tdms(folder, data), check=both(aligned(right), modes(d)))


@case("ninth")
def uff_half_a_sample(folder: Path) -> Known:
    """The abscissa's minimum of the last record is half a step."""
    d, rows, right = between("uff_half_a_sample")
    first, second, third = functions(Record(*rows, d.rate), double=True)
    late = Function(
        third.values, third.step, 0.5 / d.rate, response=third.response, ordinate=third.ordinate, double=True
    )
    return Known(save_uff(folder, text_58([first, second, late])), check=both(aligned(right), modes(d)))


@case("ninth")
def sep_half_a_sample(folder: Path) -> Known:
    """The last series' times begin half a sample later."""
    d, rows, right = between("sep_half_a_sample")
    series = [
        {"name": n, "data": row.tolist(), "unit_str": u, "time": ((np.arange(len(row)) + late) / d.rate).tolist()}
        for n, u, row, late in zip(NAMES, UNITS, rows, (0, 0, 0.5), strict=True)
    ]
    (folder / "case.json").write_text(json.dumps(series), encoding="utf-8")
    return Known(("case.json",), check=both(aligned(right), modes(d)))


@draws("ninth")
def uff_small_d_modes(folder: Path, d: Drawn) -> Known:
    """2411 and complex modes in 55, all exponents with a small d, as a Fortran program writes them."""
    lines = nodes_2411([(1, 0.1, 0, 0), (2, 0.3, 0, 0)])
    for k, (f0, zeta, phi) in enumerate(d.modes, 1):
        w = 2 * np.pi * f0
        pole = complex(-zeta * w, w * np.sqrt(1 - zeta**2))
        lines += shapes_55(k, (pole.real, pole.imag, 0, 1, 0, 0), {n: (0, 0, v + 0j) for n, v in enumerate(phi, 1)})
    lines = [line.replace("E+", "d+").replace("E-", "d-") for line in lines]

    def right(where: Path) -> str:
        found = json.loads((where / "out.json").read_text())["modes"]
        values = [(m["frequency_hz"], m["damping_ratio"], m["shape"]["1"][2][0], m["shape"]["2"][2][0]) for m in found]
        wanted = [(f0, zeta, *phi) for f0, zeta, phi in d.modes]
        return "" if np.shape(values) == np.shape(wanted) and np.allclose(values, wanted, rtol=1e-3) else f"{found}"

    return Known(save_uff(folder, lines), check=right, rig=None, options=())


@draws("ninth")
def uff_damaged_exponent(folder: Path, d: Drawn) -> Known:
    """One sample of the second response says E+90 where its neighbours are below 1000."""
    r = d.hit()
    a2 = r.a2.copy()
    a2[900] = 1e90

    def named(where: Path) -> str:
        code, said, model = identified(where)
        return "" if "a2" in said and (code or model) else f"nobody named a2: {said[-300:]}"

    lines = header_151() + text_58(functions(Record(r.force, r.a1, a2, r.rate), double=True))
    return Known(save_uff(folder, lines), rejected="(?i)a2: 1 of .* beyond .* sample 900", check=named)


@draws("ninth")
def matlab_single_times(folder: Path, d: Drawn) -> Known:
    """Times in single precision from 100 s on: a step is known to a tenth only, the rate from the whole column."""
    r = d.hit()
    t = (100 + np.arange(d.n) / d.rate).astype("f4")
    scipy.io.savemat(folder / "case.mat", {"time": t, "force": r.force, "a1": r.a1, "a2": r.a2})
    return Known(("case.mat",), check=modes(d), rejected="(?i)digit|precision|coarse")


@draws("ninth")
def matlab_frf_of_an_input(folder: Path, d: Drawn) -> Known:
    """FRFs as (1 input, 2 outputs, lines), a column of lines: by a map, or the file's sizes leave no choice."""
    h = d.frf()
    scipy.io.savemat(folder / "case.mat", {"f": h.frequency, "H": h.values[None]})
    said = ("--variable", "frequency=f", "frf=H")
    return Known(("case.mat",), frf=h, options=(*DRIVEN, *said), rejected="(?i)map|axes|order")


@draws("ninth")
def npz_frf(folder: Path, d: Drawn) -> Known:
    """numpy.savez of f (lines) and H (2 outputs, 1 input, lines)."""
    h = d.frf()
    np.savez(folder / "case.npz", f=h.frequency, H=h.values[:, None])
    said = ("--variable", "frequency=f", "frf=H")
    return Known(("case.npz",), frf=h, options=(*DRIVEN, *said), rejected="(?i)map|npz|.mat")


@draws("ninth")
def hdf5_compound(folder: Path, d: Drawn) -> Known:
    """One dataset of a compound type with time, force, a1, a2, as PyTables writes a table."""
    r = d.hit()
    table = np.zeros(d.n, [("time", "f8"), ("force", "f8"), ("a1", "f8"), ("a2", "f8")])
    for name, row in zip(("time", *NAMES), (r.time, *r.rows), strict=True):
        table[name] = row
    with h5py.File(folder / "case.h5", "w") as file:
        file["records/table"] = table
        file["records/table"].attrs.update({"CLASS": "TABLE", "VERSION": "2.7"})
    return Known(("case.h5",), (r,), rejected="(?i)compound|fields|table")


@draws("ninth")
def netcdf_classic(folder: Path, d: Drawn) -> Known:
    """netCDF 3, times since a date by the CF conventions, a unit each, in single precision."""
    r = d.hit()
    with scipy.io.netcdf_file(folder / "case.nc", "w") as file:
        file.createDimension("time", d.n)
        for name, unit, row in zip(("time", *NAMES), ("seconds since 2026-11-28 10:00:00", *UNITS),
                                   (r.time, *r.rows), strict=True):  # fmt: skip
            variable = file.createVariable(name, "d" if name == "time" else "f", ("time",))
            variable[:] = row
            variable.units = unit
    return Known(("case.nc",), (r,), rejected="(?i)is no netCDF4")


@case("ninth")
def wav_a_law(folder: Path) -> Known:
    """Format 6, A-law, as telephones use it: no linear samples."""
    data = np.zeros((2000, 3), "u1").tobytes()
    body = b"WAVE" + chunk(b"fmt ", struct.pack("<HHIIHHH", 6, 3, 8000, 24000, 3, 8, 0)) + chunk(b"data", data)
    (folder / "case.wav").write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)
    return Known(("case.wav",), options=(*DRIVEN, "--volts"), rejected="(?i)a-law|format 6|tag 6|encod|format",
                 rig=PLAIN.replace(", point", ", sensitivity_v_per_unit: 0.01, point"))  # fmt: skip


@draws("ninth")
def tdms_table_scale(folder: Path, d: Drawn) -> Known:
    """Raw volts with a scale of type Table: pairs of volts and m/s^2 between which lines are drawn."""
    r = d.hit()
    facts = waved(d)
    table = {"NI_Number_Of_Scales": 2, "NI_Scaling_Status": "unscaled", "NI_Scale[1]_Scale_Type": "Table"}
    table |= {"NI_Scale[1]_Table_Scaled_Values_Size": 2, "NI_Scale[1]_Table_Pre_Scaled_Values_Size": 2}
    table |= {"NI_Scale[1]_Table_Input_Source": 0xFFFFFFFF}
    table |= {f"NI_Scale[1]_Table_Pre_Scaled_Values[{k}]": v for k, v in enumerate((-1000.0, 1000.0))}
    table |= {f"NI_Scale[1]_Table_Scaled_Values[{k}]": v for k, v in enumerate((-2000.0, 2000.0))}
    facts[2] |= table
    rows = (r.force, r.a1, r.a2 / 2)
    objects = [thing("/"), thing("/'hit'")]
    objects += [thing(p, row, f) for p, row, f in zip((FORCE, A1, A2), rows, facts, strict=True)]
    data = tdms_segment(objects, b"".join(row.tobytes() for row in rows))
    return Known(save_tdms(folder, data), (r,), rejected="(?i)table")
