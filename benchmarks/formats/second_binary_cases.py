"""A second draw, after what the first one showed was mended: TDMS, WAV, NPY, MATLAB, universal files and SEP005."""

from pathlib import Path

import numpy as np
import scipy.io
from array_cases import save as save_array
from array_cases import wave
from known import RATE, VOLTS, G, Known, KnownFrf, Record, case, hit, inertance
from sep005_cases import listed
from sep005_cases import save as save_sep
from tdms_cases import save as save_tdms
from tdms_cases import waved, whole
from uff_cases import LINES, frfs, functions
from uff_cases import save as save_uff
from uff_written import ACCELERATION, FORCE, Function, text_58


@case("second binary")
def tdms_unit_description(folder: Path) -> Known:
    """The unit stands in NI_UnitDescription only."""
    record = hit()
    props = [{k: v for k, v in p.items() if k != "unit_string"} for p in waved()]
    props = [p | {"NI_UnitDescription": u} for p, u in zip(props, ("N", "g", "g"), strict=True)]
    return Known(save_tdms(folder, whole([record.force, record.a1 / G, record.a2 / G], props)), (record,))


@case("second binary")
def tdms_long_units(folder: Path) -> Known:
    """Units as LabVIEW spells them: Newtons, m/s², g."""
    record = hit()
    props = [p | {"unit_string": u} for p, u in zip(waved(), ("Newtons", "m/s²", "g"), strict=True)]
    return Known(save_tdms(folder, whole([record.force, record.a1, record.a2 / G], props)), (record,))


@case("second binary")
def tdms_volts(folder: Path) -> Known:
    """Volts and millivolts of sensors whose sensitivity the rig knows."""
    record = hit()
    props = [p | {"unit_string": u} for p, u in zip(waved(), ("V", "mV", "mV"), strict=True)]
    rows = [record.force * 0.01, record.a1 * 10, record.a2 * 10]
    return Known(save_tdms(folder, whole(rows, props)), (record,), rig=VOLTS)


@case("second binary")
def tdms_shorter_channel(folder: Path) -> Known:
    """The last channel has five samples less and begins with the others."""
    record = hit()
    rows = [record.force, record.a1, record.a2[:-5]]
    return Known(save_tdms(folder, whole(rows, waved())), (record.part(0, -5),), rejected="(?i)a2.*1019|1019.*a2")


@case("second binary")
def tdms_before_the_trigger(folder: Path) -> Known:
    """All offsets are the same and negative."""
    record = hit()
    return Known(save_tdms(folder, whole(list(record.rows), waved(wf_start_offset=-0.03))), (record,))


@case("second binary")
def tdms_no_increment(folder: Path) -> Known:
    """No channel says its rate: it is asked for."""
    props = [{k: v for k, v in p.items() if k != "wf_increment"} for p in waved()]
    return Known(save_tdms(folder, whole(list(hit().rows), props)), rejected="(?i)rate")


@case("second binary")
def wav_16_bit(folder: Path) -> Known:
    """16 bit of sensors' volts, full scale 1 V."""
    record = hit()
    volts = record.rows * np.array([[0.004], [0.004], [0.004]])
    rig = VOLTS.replace("0.01}", "0.004}")
    counts = np.round(volts.T * 2**15).astype("<i2")
    options = ("--drive-point", "1", "--volts")
    files = save_array(folder, "case.wav", wave(counts.tobytes(), 1, 16))
    return Known(files, (record,), rig=rig, options=options, tolerance=2e-4)


@case("second binary")
def npy_counts(folder: Path) -> Known:
    """Counts of a converter without a scale."""
    np.save(folder / "case.npy", np.round(hit().rows * 100).astype(np.int16))
    return Known(("case.npy",), options=("--drive-point", "1", "--rate", "2000"), rejected="(?i)int16|whole|floating")


@case("second binary")
def mat_times_beside_values(folder: Path) -> Known:
    """Each signal as (n, 2): times and values, as a simulation tool logs them."""
    record = hit()
    parts = {n: np.column_stack([record.time, r]) for n, r in zip(("force", "a1", "a2"), record.rows, strict=True)}
    scipy.io.savemat(folder / "case.mat", parts | {"fs": RATE})
    return Known(("case.mat",), (record,), rejected=r"(?i)\(?1024, ?2|1024x2|column|two")


@case("second binary")
def mat_other_lengths(folder: Path) -> Known:
    """One channel has fewer samples."""
    record = hit()
    parts = {"force": record.force, "a1": record.a1, "a2": record.a2[:-7], "fs": RATE}
    scipy.io.savemat(folder / "case.mat", parts)
    return Known(("case.mat",), rejected="(?i)a2.*1017|1017.*a2|length")


@case("second binary")
def mat_complex_records(folder: Path) -> Known:
    """Spectra where records are expected."""
    record = hit()
    parts = {n: np.fft.fft(r) for n, r in zip(("force", "a1", "a2"), record.rows, strict=True)}
    scipy.io.savemat(folder / "case.mat", parts | {"fs": RATE})
    return Known(("case.mat",), rejected="(?i)complex")


@case("second binary")
def uff_uneven_records(folder: Path) -> Known:
    """Records with their times, 2(E13.5,E20.12)."""
    record = hit()
    parts = functions(record, double=True, lines=record.time)
    return Known(save_uff(folder, text_58(parts)), (record,))


@case("second binary")
def uff_no_last_mark(folder: Path) -> Known:
    """The last line `-1` is missing."""
    lines = text_58(functions(hit()))[:-1]
    return Known(save_uff(folder, lines), rejected="(?i)set 3 does not end")


@case("second binary")
def uff_whole_unit_beside_response(folder: Path) -> Known:
    """The label of the response is that of the ratio, (m/s2)/N, and the force has none."""
    right = KnownFrf(LINES, inertance(LINES)[:, 0])
    parts = frfs(right.values, unit="(m/s2)/N", denominator=(FORCE, "NONE"))
    return Known(save_uff(folder, text_58(parts)), frf=right)


@case("second binary")
def uff_inches_by_label(folder: Path) -> Known:
    """Labels lbf and in/s^2."""
    record = hit()
    scaled = Record(record.force / 4.4482216152605, record.a1 / 0.0254, record.a2 / 0.0254)
    return Known(save_uff(folder, text_58(functions(scaled, ("lbf", "in/s^2", "in/s^2")))), (record,))


@case("second binary")
def uff_two_references(folder: Path) -> Known:
    """FRFs to two points, one of them missing for one response."""
    h = inertance(LINES, inputs=(0, 1))
    parts = frfs(h[:, 0]) + frfs(h[:1, 1], reference=(2, 3))
    return Known(save_uff(folder, text_58(parts)), rejected="(?i)no FRF of channel a2 to node 2", options=())


@case("second binary")
def uff_response_across(folder: Path) -> Known:
    """The second response is along X, the rig's along Z."""
    parts = functions(hit())
    last = Function(parts[2].values, 1 / RATE, response=(2, 1), ordinate=(ACCELERATION, "m/s^2"))
    return Known(save_uff(folder, text_58([*parts[:2], last])), rejected=r"(?i)\+x")


@case("second binary")
def uff_rates_differ(folder: Path) -> Known:
    """One record at half the rate."""
    record = hit()
    parts = functions(record)
    last = Function(record.a2[::2], 2 / RATE, response=(2, 3), ordinate=(ACCELERATION, "m/s^2"))
    return Known(save_uff(folder, text_58([*parts[:2], last])), rejected="(?i)differ in rate")


@case("second binary")
def sep_columns(folder: Path) -> Known:
    """Data as columns [[1], [2], ...], units m/s² and kN."""
    record = hit()
    series = listed([record.force / 1e3, record.a1, record.a2], ("kN", "m/s²", "m/s²"))
    for entry in series:
        entry["data"] = [[v] for v in entry["data"]]
    return Known(save_sep(folder, series), (record,), rejected="(?i)shape|list|dimension|nested|numbers")


@case("second binary")
def sep_without_units(folder: Path) -> Known:
    """No unit_str, which the guideline requires."""
    series = listed(list(hit().rows))
    for entry in series:
        del entry["unit_str"]
    return Known(save_sep(folder, series), (hit(),), rejected="(?i)unit_str")


@case("second binary")
def sep_apart(folder: Path) -> Known:
    """Records that do not overlap."""
    series = listed(list(hit().rows))
    for entry, minute in zip(series, (0, 0, 5), strict=True):
        entry["start_timestamp"] = f"2026-03-29T10:{minute:02d}:00+00:00"
    return Known(save_sep(folder, series), rejected="(?i)overlap|different times|together")
