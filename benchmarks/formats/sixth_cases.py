"""A sixth draw: forty files, written after the reader of tables was made anew and before it was run on them."""

import json
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from clock_cases import at
from fifth_cases import cells, one_response, parts
from fourth_cases import HEAD, NAMES, german, rows_of
from frf_cases import LINES, plain, polar
from known import MODES, PLAIN, RATE, VOLTS, G, Known, KnownFrf, Record, case, hit, moved, receptance
from lvm_cases import head as lvm_head
from lvm_cases import save as save_lvm
from lvm_cases import segment
from tdms_cases import save as save_tdms
from tdms_cases import waved, whole
from text_cases import save
from uff_cases import frfs, functions
from uff_cases import save as save_uff
from uff_written import binary_58, text_58, units_164

DRIVEN = ("--drive-point", "1")


@case("sixth")
def facts_as_json(folder: Path) -> Known:
    """A comment with JSON, one with names in other order, then the header in order."""
    lines = ['# {"rate": 2000, "operator": "x", "n": 3}', "# force, a1, a2 at point 1", HEAD]
    return Known(save(folder, [*lines, *rows_of(hit())]), (hit(),))


@case("sixth")
def index_of_pandas(folder: Path) -> Known:
    """DataFrame.to_csv: an index without a name in front."""
    rows = [f"{i},{row}" for i, row in enumerate(rows_of(hit()))]
    return Known(save(folder, ["," + HEAD, *rows]), (hit(),))


@case("sixth")
def table_of_r(folder: Path) -> Known:
    """R's write.table: names in quotes, row numbers in quotes without a name of their own."""
    rows = [f'"{i + 1}" {row}' for i, row in enumerate(rows_of(hit(), between=" "))]
    return Known(save(folder, ['"time" "force" "a1" "a2"', *rows]), (hit(),), rejected="--columns")


@case("sixth")
def octave_text(folder: Path) -> Known:
    """Octave's save -text: comments say name, type, rows and columns; blanks in front of each row."""
    head = ["# Created by Octave 9.1", "# name: x", "# type: matrix", "# rows: 1024", "# columns: 4"]
    rows = [" " + row for row in rows_of(hit(), between=" ")]
    return Known(save(folder, [*head, *rows, "", ""], name="case.txt"), (hit(),))


@case("sixth")
def two_dates(folder: Path) -> Known:
    """A column of start dates that never change beside the clock."""
    rows = [
        f"{at(i):%Y-%m-%d %H:%M:%S.%f};{row.partition(';')[2]};2026-03-29"
        for i, row in enumerate(rows_of(hit(), between=";"))
    ]
    return Known(save(folder, ["Time;force [N];a1 [m/s^2];a2 [m/s^2];calibrated", *rows]), (hit(),))


@case("sixth")
def units_below_with_dash(folder: Path) -> Known:
    """A line of dashes between the names and the numbers, blanks of width."""
    rows = [row.replace(",", "   ") for row in rows_of(hit())]
    head = ["Time      force     a1        a2", "--------- --------- --------- ---------"]
    return Known(save(folder, [*head, *rows], name="case.txt"), (hit(),))


@case("sixth")
def markdown_table(folder: Path) -> Known:
    """| time | force | ... | with a line of dashes, as notebooks print tables."""
    rows = ["| " + row.replace(",", " | ") + " |" for row in rows_of(hit())]
    head = ["| time [s] | force [N] | a1 [m/s^2] | a2 [m/s^2] |", "|---|---|---|---|"]
    return Known(save(folder, [*head, *rows], name="case.txt"), (hit(),))


@case("sixth")
def whole_counts(folder: Path) -> Known:
    """Whole millivolts, a whole number of the sample in front, no times; rate and columns said."""
    record = hit()
    volts = np.round(record.rows * 1000)
    rows = [f"{i}\t" + "\t".join(f"{v:.0f}" for v in row) for i, row in enumerate(volts.T)]
    right = Record(*(volts / 1000))
    options = (*DRIVEN, "--rate", "2000", "--columns", ",force:mN,a1:mm/s^2,a2:mm/s^2")
    return Known(save(folder, rows), (right,), options=options)


@case("sixth")
def wide_decimal_comma_blanks(folder: Path) -> Known:
    """Decimal commas, columns by blanks, a German head."""
    rows = german(rows_of(hit(), between="  "))
    return Known(save(folder, ["Zeit  force  a1  a2", *rows], name="case.asc"), (hit(),))


@case("sixth")
def three_channels_whole_and_comma(folder: Path) -> Known:
    """Semicolons; times in whole ms/2 as 0,5; forces whole numbers with points between thousands only once."""
    record = hit()
    force = np.round(record.force * 1000)
    rows = [f"{comma(i / 2)};{f'{f:,.0f}'.replace(',', '.')};{comma(a)};{comma(b)}"
            for i, (f, a, b) in enumerate(zip(force, record.a1, record.a2, strict=True))]  # fmt: skip
    right = Record(force / 1000, record.a1, record.a2)
    return Known(save(folder, ["t [ms];force [mN];a1 [m/s²];a2 [m/s²]", *rows]), (right,), rejected="thousands")


def comma(value: float) -> str:
    return f"{value:.6f}".replace(".", ",")


@case("sixth")
def ends_with_remarks(folder: Path) -> Known:
    """Three lines of words below the table."""
    return Known(
        save(folder, [HEAD, *rows_of(hit()), "", "End of data", "Operator: x"]),
        (hit(),),
        rejected="(?i)end of data|below",
    )


@case("sixth")
def missing_first_value(folder: Path) -> Known:
    """The first row holds n/a for a2."""
    rows = rows_of(hit())
    rows[0] = rows[0].rpartition(",")[0] + ",n/a"
    return Known(save(folder, [HEAD, *rows]), rejected="n/a")


@case("sixth")
def second_sensor_at_half_rate(folder: Path) -> Known:
    """Every second cell of a slower channel is empty; it is no channel of the rig."""
    rows = [f"{row},{20.5 if i % 2 == 0 else ''}" for i, row in enumerate(rows_of(hit()))]
    return Known(save(folder, [HEAD + ",temperature [°C]", *rows]), (hit(),))


@case("sixth")
def same_names_as_units(folder: Path) -> Known:
    """Channels called N and g, as a careless export names them by their units; variables said."""
    rows = rows_of(hit(), factors=(1, 1 / G, 1 / G), digits=9)
    said = ("--columns", "time:s,force:N,a1:g,a2:g")
    return Known(save(folder, ["s,N,g,g", *rows]), (hit(),), options=(*DRIVEN, *said))


@case("sixth")
def header_of_units_only(folder: Path) -> Known:
    """The same without saying anything."""
    rows = rows_of(hit(), factors=(1, 1 / G, 1 / G), digits=9)
    return Known(save(folder, ["s,N,g,g", *rows]), rejected="--columns|no line|no header")


@case("sixth")
def latin_and_tabs_with_crlf(folder: Path) -> Known:
    """cp1252 with µm/s² and CRLF; accelerations in µm/s²."""
    rows = rows_of(hit(), between="\t", factors=(1, 1e6, 1e6), digits=3)
    head = "Time [s]\tforce [N]\ta1 [µm/s²]\ta2 [µm/s²]"
    return Known(save(folder, [head, *rows], "cp1252", "\r\n"), (hit(),), rejected="(?i)m/s")


@case("sixth")
def kilopond(folder: Path) -> Known:
    """Force in kgf, accelerations in Gal: units that are seldom."""
    rows = rows_of(hit(), factors=(1 / G, 100, 100), digits=9)
    return Known(save(folder, ["time [s],force [kgf],a1 [Gal],a2 [Gal]", *rows]), (hit(),), rejected="kgf|Gal")


@case("sixth")
def milliseconds_without_unit(folder: Path) -> Known:
    """Times in ms that nothing says: a rate of 2 Hz, which --rate contradicts."""
    rows = rows_of(hit(), lambda i: f"{1e3 * i / RATE:.3f}")
    return Known(save(folder, ["time,force,a1,a2", *rows]), rejected="2 Hz", options=(*DRIVEN, "--rate", "2000"))


@case("sixth")
def facts_with_y_unit(folder: Path) -> Known:
    """An analyser's `Y-Axis Unit: g/N` above unnamed parts of one FRF."""
    facts = ["Title: FRF", "X-Axis Unit: Hz", "Y-Axis Unit: g/N", ""]
    a, b = (v / G for v in parts()[:2])
    rig = "\n".join(line for line in PLAIN.splitlines() if "name: a2" not in line) + "\n"
    files = save(folder, [*facts, "Frequency\tReal\tImaginary", *cells("\t", LINES, a, b)], name="case.txt")
    return Known(files, check=one_response(plain()), rig=rig)


@case("sixth")
def real_only(folder: Path) -> Known:
    """Frequency and levels without phases."""
    (m1, _), (m2, _) = (polar(h) for h in plain().values)
    head = "Frequency [Hz],a1 [dB re 1 m/s^2/N],a2 [dB re 1 m/s^2/N]"
    return Known(save(folder, [head, *cells(",", LINES, 20 * np.log10(m1), 20 * np.log10(m2))]), rejected="(?i)phase")


@case("sixth")
def points_and_axes(folder: Path) -> Known:
    """Columns Re(H_1z_1z) and so on, omega in rad/s."""
    head = "omega [rad/s],Re(1z/1z) [m/s^2/N],Im(1z/1z) [m/s^2/N],Re(2z/1z) [m/s^2/N],Im(2z/1z) [m/s^2/N]"
    return Known(save(folder, [head, *cells(",", 2 * np.pi * LINES, *parts())]), frf=plain())


@case("sixth")
def compliance_in_micrometres(folder: Path) -> Known:
    """Receptances in µm/N of displacements."""
    from known import DISPLACEMENT

    h = receptance(LINES)[:, 0]
    head = "f (Hz);Re a1 (µm/N);Im a1 (µm/N);Re a2 (µm/N);Im a2 (µm/N)"
    rows = cells(";", LINES, *(v for one in 1e6 * h for v in (one.real, one.imag)))
    return Known(save(folder, [head, *rows]), frf=KnownFrf(LINES, h, "receptance"), rig=DISPLACEMENT)


@case("sixth")
def lines_twice(folder: Path) -> Known:
    """A line of the spectrum stands twice, as after two bands were joined."""
    rows = cells(",", LINES, *parts())
    rows.insert(200, rows[200])
    return Known(save(folder, ["f [Hz],Re a1,Im a1,Re a2,Im a2", *rows]), rejected="(?i)ascend|followed|twice")


@case("sixth")
def phase_in_a_unit_row(folder: Path) -> Known:
    """Units in a row of their own: Hz, (m/s²)/N, °."""
    (m1, p1), (m2, p2) = (polar(h) for h in plain().values)
    head = ["Frequency;a1 Magnitude;a1 Phase;a2 Magnitude;a2 Phase", "Hz;(m/s²)/N;°;(m/s²)/N;°"]
    return Known(save(folder, [*head, *cells(";", LINES, m1, p1, m2, p2)]), frf=plain())


@case("sixth")
def lvm_two_rows_of_special(folder: Path) -> Known:
    """LabVIEW: a block of special lines with numbers in it before the segment."""
    text = lvm_head()
    text[-1:] = ["***Start_Special***", "1\t2\t3", "Version\t7", "***End_Special***", ""]
    return Known(save_lvm(folder, text + segment(list(hit().rows))), (hit(),))


@case("sixth")
def lvm_without_rate(folder: Path) -> Known:
    """LabVIEW without X columns and with Delta_X of 1: samples were counted, and the rate is given."""
    text = lvm_head(columns="No") + segment(list(hit().rows), "No", delta=(1.0, 1.0, 1.0))
    return Known(save_lvm(folder, text), (hit(),), options=(*DRIVEN, "--rate", "2000"))


@case("sixth")
def tdms_of_big_endian_shorts(folder: Path) -> Known:
    """TDMS, big-endian, single precision, start times and offsets that agree."""
    data = whole([r.astype("f4") for r in hit().rows], waved(wf_start_offset=0.25), order=">")
    return Known(save_tdms(folder, data), (hit(),))


@case("sixth")
def tdms_of_volts(folder: Path) -> Known:
    """TDMS with unit_string Volts."""
    props = [p | {"unit_string": "Volts"} for p in waved()]
    return Known(save_tdms(folder, whole([r * 0.01 for r in hit().rows], props)), (hit(),), rig=VOLTS)


@case("sixth")
def uff_of_kilonewtons(folder: Path) -> Known:
    """Labels kN and mm/s^2 in dataset 58."""
    record = hit()
    scaled = Record(record.force / 1e3, record.a1 * 1e3, record.a2 * 1e3)
    return Known(save_uff(folder, text_58(functions(scaled, ("kN", "mm/s^2", "mm/s^2"), double=True))), (record,))


@case("sixth")
def uff_of_other_units_code(folder: Path) -> Known:
    """Dataset 164 with code 9 and its own factors, no labels."""
    own = (9, "USER_DEFINED", 100.0, 1.0)
    record = hit()
    scaled = Record(record.force, record.a1 * 100, record.a2 * 100)
    lines = units_164(own) + text_58(functions(scaled, ("NONE",) * 3, double=True))
    return Known(save_uff(folder, lines), (record,), rejected="(?i)unit|factor|code")


@case("sixth")
def uff_frfs_before_spectra(folder: Path) -> Known:
    """58b: FRFs in big-endian single precision, by dataset after dataset."""
    data = b"".join(binary_58(f, big=True) for f in frfs(plain().values))
    return Known(save_uff(folder, data), frf=plain())


@case("sixth")
def matlab_units_in_a_list(folder: Path) -> Known:
    """A matrix, names in a cell, units in another: kN, g, g."""
    record = hit()
    data = np.column_stack([record.force / 1e3, record.a1 / G, record.a2 / G])
    named = {"names": np.array(NAMES, object), "units": np.array(["kN", "g", "g"], object)}
    scipy.io.savemat(folder / "case.mat", {"data": data, "Fs": RATE, **named})
    return Known(("case.mat",), (record,))


@case("sixth")
def matlab_time_of_each(folder: Path) -> Known:
    """A structure a channel with time and data; the second begins three samples later."""
    rows, right = moved(hit(), (0, 3, 0))
    content = {
        n: {"time": (k + np.arange(len(r))) / RATE, "data": r} for n, r, k in zip(NAMES, rows, (0, 3, 0), strict=True)
    }
    scipy.io.savemat(folder / "case.mat", content)
    return Known(("case.mat",), (right,))


@case("sixth")
def matlab_row_vectors_and_text(folder: Path) -> Known:
    """Row vectors, notes as text, an empty array and a logical beside them."""
    record = hit()
    content = dict(zip(NAMES, record.rows, strict=True)) | {"t": record.time, "note": "hit", "empty": [], "ok": True}
    scipy.io.savemat(folder / "case.mat", content)
    return Known(("case.mat",), (record,))


@case("sixth")
def hdf5_matrix_and_names(folder: Path) -> Known:
    """HDF5: a matrix (samples, channels) with attributes fs and channel names as strings."""
    record = hit()
    with h5py.File(folder / "case.h5", "w") as file:
        file["data"] = record.rows.T
        file.attrs["fs"] = RATE
        file["channel_names"] = np.array(NAMES, dtype=h5py.string_dtype())
    return Known(("case.h5",), (record,))


@case("sixth")
def hdf5_of_pandas(folder: Path) -> Known:
    """HDF5 of a data frame: block0_items and block0_values, axis0, axis1."""
    record = hit()
    with h5py.File(folder / "case.h5", "w") as file:
        group = file.create_group("df")
        group["axis0"] = np.array(NAMES, dtype="S5")
        group["axis1"] = record.time
        group["block0_items"] = np.array(NAMES, dtype="S5")
        group["block0_values"] = record.rows.T
    return Known(("case.h5",), (record,), rejected="(?i)time|rate|channel")


@case("sixth")
def npz_matrix(folder: Path) -> Known:
    """numpy.savez of fs, data (channels, samples) and names."""
    np.savez(folder / "case.npz", fs=RATE, data=hit().rows, names=np.array(NAMES))
    return Known(("case.npz",), (hit(),))


@case("sixth")
def npy_of_frfs(folder: Path) -> Known:
    """Complex numbers in an .npy: no lines, no names."""
    np.save(folder / "case.npy", plain().values)
    return Known(("case.npy",), rejected="complex")


@case("sixth")
def sep_in_millivolts(folder: Path) -> Known:
    """SEP005 with unit_str mV, sensitivities in the rig."""
    series = [
        {"name": n, "data": (10 * r).tolist(), "unit_str": "mV", "fs": RATE}
        for n, r in zip(NAMES, hit().rows, strict=True)
    ]
    (folder / "case.json").write_text(json.dumps(series), encoding="utf-8")
    return Known(("case.json",), (hit(),), rig=VOLTS)


@case("sixth")
def modes_in_a_table(folder: Path) -> Known:
    """A table of frequencies and damping ratios: results, no record."""
    rows = [f"{k},{f0},{100 * zeta}" for k, (f0, zeta, _) in enumerate(MODES, start=1)]
    return Known(save(folder, ["Mode,Frequency [Hz],Damping [%]", *rows]), rejected="(?i)phase|record|channel|column")
