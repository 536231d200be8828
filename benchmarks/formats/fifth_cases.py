"""A fifth draw: forty files of analysers, loggers and libraries, as their documents show them."""

import json
import zipfile
from pathlib import Path

import h5py
import numpy as np
import scipy.io
from clock_cases import at
from fourth_cases import NAMES, german, rows_of
from frf_cases import LINES, plain, polar
from known import MODES, PLAIN, RATE, G, Known, KnownFrf, case, hit
from lvm_cases import head as lvm_head
from lvm_cases import save as save_lvm
from lvm_cases import segment
from tdms_cases import save as save_tdms
from tdms_cases import waved, whole
from text_cases import save
from uff_cases import functions, modes_right
from uff_cases import save as save_uff
from uff_written import binary_58, header_151, nodes_2411, shapes_55, text_58

BY_COLUMNS = "--columns"
DRIVEN = ("--drive-point", "1")


def cells(between: str, *columns: np.ndarray) -> list[str]:
    return [between.join(f"{v:.8g}" for v in row) for row in np.array(columns).T]


def parts() -> list[np.ndarray]:
    (x, y) = plain().values
    return [x.real, x.imag, y.real, y.imag]


@case("fifth")
def catman(folder: Path) -> Known:
    """HBM catman ASCII: facts with tabs, a line of names, of units, of rates and of sensors, decimal commas."""
    facts = ["HBM_CATMAN_ASCII", "T0=29.03.2026 10:00:00", "Kanäle:\t4", ""]
    lines = ["Zeit\tforce\ta1\ta2", "s\tN\tm/s²\tm/s²", *["2000 Hz\t2000 Hz\t2000 Hz\t2000 Hz"]]
    lines += ["\tMX840 CH 1\tMX840 CH 2\tMX840 CH 3"]
    return Known(save(folder, [*facts, *lines, *german(rows_of(hit(), between="\t"))], "cp1252"), (hit(),))


@case("fifth")
def dewesoft(folder: Path) -> Known:
    """Dewesoft: facts, a table of the channels that begins with their numbers, then the table of samples."""
    facts = ["Data file information", "", "File name:\thit.dxd", "Start time:\t29.03.2026 10:00:00.000"]
    facts += ["Sample rate:\t2000\tHz", "", "Channel information", "Ch. no.\tName\tUnit\tRange"]
    facts += ["0\tforce\tN\t-500..500", "1\ta1\tm/s2\t-100..100", "2\ta2\tm/s2\t-100..100", "", "Data1"]
    head = "Time (s)\tforce (N)\ta1 (m/s2)\ta2 (m/s2)"
    return Known(save(folder, [*facts, head, *rows_of(hit(), between="\t")], name="case.txt"), (hit(),))


@case("fifth")
def oros(folder: Path) -> Known:
    """NVGate: a name and then a value for each channel, the abscissa in front of every row."""
    facts = [
        "Project\tblade",
        "Label\tforce\ta1\ta2",
        "X unit\ts\ts\ts",
        "Y unit\tN\tm/s²\tm/s²",
        "Size\t1024\t1024\t1024",
    ]
    head = "Time\tforce\ta1\ta2"
    return Known(save(folder, [*facts, "", head, *rows_of(hit(), between="\t")], name="case.txt"), (hit(),))


@case("fifth")
def polytec(folder: Path) -> Known:
    """Polytec: four facts, then Frequency, Real, Imaginary with units in spaced brackets; one response a file."""
    right = plain()
    facts = ["Source File Name: beam.pvd", "Point Index: 1", "Component: Z"]
    facts += ["Signal: FFT - Acceleration / Force - H1 - Real & Imag.", ""]
    head = ["Frequency\tReal\tImaginary", "[ Hz ]\t[ (m/s²) / N ]\t[ (m/s²) / N ]"]
    rows = cells("\t", LINES, *parts()[:2])
    rig = "\n".join(line for line in PLAIN_LINES if "name: a2" not in line) + "\n"
    return Known(save(folder, [*facts, *head, *rows], "cp1252", name="case.txt"), check=one_response(right), rig=rig)


PLAIN_LINES = PLAIN.splitlines()


def one_response(right: KnownFrf):
    def check(folder: Path) -> str:
        from modallab.formats import read_campaign

        (frf,) = read_campaign(folder / "out.h5").frfs
        off = np.abs(frf.values[0, 0] - right.values[0]).max() / np.abs(right.values[0]).max()
        return "" if off < 1e-6 and frf.quantity == right.quantity else f"off by {off:.3g}, {frf.quantity}"

    return check


@case("fifth")
def pulse_rows_with_index(folder: Path) -> Known:
    """PULSE: `Header Size: 10` and facts, then index, frequency, real, imaginary without names."""
    facts = ["Header Size: 10", "Version: 2.0", "Title: Frequency Response H1(a1,force)", "X-Axis Unit: Hz"]
    facts += ["X-Axis size: 400", "Y-Axis Unit: (m/s^2)/N", "Date: 29-03-2026", "Time: 10:00:00", "Nodes: 1", ""]
    rows = cells("\t", np.arange(1, 401), LINES, *parts()[:2])
    return Known(save(folder, [*facts, *rows], name="case.txt"), rejected=BY_COLUMNS)


@case("fifth")
def pulse_with_columns_said(folder: Path) -> Known:
    """The same with two responses, and the columns said."""
    known = pulse_rows_with_index(folder)
    text = (folder / known.files[0]).read_text().splitlines()
    rows = [f"{row}\t{more}" for row, more in zip(text[10:], cells("\t", *parts()[2:]), strict=True)]
    said = ("--columns", ",frequency:Hz,Re a1:m/s^2/N,Im a1,Re a2:m/s^2/N,Im a2")
    return Known(save(folder, [*text[:10], *rows], name="case.txt"), frf=plain(), options=(*DRIVEN, *said))


@case("fifth")
def testlab_side_by_side(folder: Path) -> Known:
    """Testlab: blocks side by side, each with its own frequency column, names above, units below."""
    a, b, c, d = parts()
    head = [
        "FRF a1/force\t\t\tFRF a2/force\t\t",
        "Linear\tReal\tImag\tLinear\tReal\tImag",
        "Hz\tg/N\tg/N\tHz\tg/N\tg/N",
    ]
    rows = cells("\t", LINES, a / G, b / G, LINES, c / G, d / G)
    return Known(save(folder, [*head, *rows], name="case.txt"), frf=plain(), rejected="(?i)twice|response|several")


@case("fifth")
def famos(folder: Path) -> Known:
    """imc FAMOS: names and units in quotes, semicolons, numbers with exponents."""
    record = hit()
    rows = [";".join(f"{v: .9E}" for v in (i / RATE, *row)) for i, row in enumerate(record.rows.T)]
    return Known(save(folder, ['"Time";"force";"a1";"a2"', '"s";"N";"m/s²";"m/s²"', *rows], "cp1252"), (record,))


@case("fifth")
def ono_sokki(folder: Path) -> Known:
    """An FFT analyser: facts with commas, X and Y units among them, then X,Real,Imag of two responses."""
    facts = ["Title,FRF", "Date,2026/03/29 10:00:00", "Lines,400", "Window,Rectangular", "Average,5,SUM(POWER)"]
    facts += ["X Unit,Hz", "Y Unit,(m/s2)/N", "", "Frequency,a1(Real),a1(Imag),a2(Real),a2(Imag)"]
    return Known(save(folder, [*facts, *cells(",", LINES, *parts())]), frf=plain())


@case("fifth")
def signalcalc(folder: Path) -> Known:
    """Names with commas in quotes: "H2,1 (Real)"; points of response and force."""
    head = '"Frequency (Hz)","H1,1 (Real)","H1,1 (Imag)","H2,1 (Real)","H2,1 (Imag)"'
    return Known(save(folder, [head, *cells(",", LINES, *parts())]), frf=plain())


@case("fifth")
def scilab(folder: Path) -> Known:
    """Scilab's csvWrite: no header, exponents with D, commas."""
    record = hit()
    rows = [",".join(f"{v:.14E}".replace("E", "D") for v in (i / RATE, *row)) for i, row in enumerate(record.rows.T)]
    return Known(save(folder, rows), (record,))


@case("fifth")
def scilab_drafted(folder: Path) -> Known:
    """The same, with the columns said and no rig file."""
    said = ("--columns", "time,force:N,a1:m/s^2,a2:m/s^2")
    return Known(scilab(folder).files, (hit(),), options=said, rig=None)


@case("fifth")
def yokogawa(folder: Path) -> Known:
    """Yokogawa: names and values a trace in quotes, no column of times, HResolution instead."""
    facts = ['"Header Size",8', '"Model Name","DL850"', '"TraceName","force","a1","a2"', '"BlockSize",1024,1024,1024']
    facts += ['"VUnit","N","m/s2","m/s2"', '"HResolution",5.0E-04,5.0E-04,5.0E-04', '"HUnit","s","s","s"', ""]
    rows = [",".join(f"{v:.7E}" for v in row) for row in hit().rows.T]
    return Known(save(folder, [*facts, *rows]), (hit(),), rejected="time|rate|--columns")


@case("fifth")
def yokogawa_with_rate(folder: Path) -> Known:
    """The same with columns and rate said."""
    options = (*DRIVEN, "--rate", "2000", "--columns", "force:N,a1:m/s2,a2:m/s2")
    return Known(yokogawa(folder).files, (hit(),), options=options)


@case("fifth")
def rion(folder: Path) -> Known:
    """Sections in brackets, then [Data] and a line of names, blanks between columns."""
    facts = ["[Header]", "Product VA-12", "Memory Mode FFT", "[Setup]", "Range 10", "[Data]"]
    rows = rows_of(hit(), between="  ")
    return Known(save(folder, [*facts, "Time force a1 a2", *rows], name="case.txt"), (hit(),))


@case("fifth")
def keysight_fra(folder: Path) -> Known:
    """A frequency response analyser: a column of numbers headed #, level in dB, phase in degrees with its sign."""
    (m1, p1), (m2, p2) = (polar(h) for h in plain().values)
    head = "#, Frequency (Hz), a1 Gain (dB), a1 Phase (°), a2 Gain (dB), a2 Phase (°)"
    rows = cells(",", np.arange(1, 401), LINES, 20 * np.log10(m1), p1, 20 * np.log10(m2), p2)
    return Known(save(folder, [head, *rows]), frf=plain(), rejected="(?i)column")


@case("fifth")
def room_wizard(folder: Path) -> Known:
    """Comment lines with *, the last of which names frequency, level and phase; blanks between columns."""
    (m1, p1), (m2, p2) = (polar(h) for h in plain().values)
    head = [
        "* Measured data",
        "* Dated: 29-Mar-2026",
        "*",
        "* Freq(Hz) a1_Mag(dB) a1_Phase(deg) a2_Mag(dB) a2_Phase(deg)",
    ]
    rows = cells(" ", LINES, 20 * np.log10(m1), p1, 20 * np.log10(m2), p2)
    return Known(save(folder, [*head, *rows], name="case.txt"), frf=plain())


@case("fifth")
def twin_builder(folder: Path) -> Known:
    """Abs(a1)[...] and Phi(a1)[rad] in quotes after a comma and a blank, f in kHz."""
    (m1, p1), (m2, p2) = (polar(h, False) for h in plain().values)
    head = '"f [kHz]", "Abs(a1)[m/s^2/N]","Phi(a1)[rad]", "Abs(a2)[m/s^2/N]","Phi(a2)[rad]"'
    return Known(save(folder, [head, *cells(",", LINES / 1e3, m1, p1, m2, p2)]), frf=plain())


@case("fifth")
def labview_waveforms(folder: Path) -> Known:
    """Export Waveforms to Spreadsheet: waveform, t0, delta t and their values, then date, clock and Y[0]."""
    facts = ["waveform\t[0]\t[1]\t[2]", "t0" + "\t29.03.2026 10:00:00,000000" * 3, "delta t" + "\t0,000500" * 3, ""]
    rows = [f"{at(i):%d.%m.%Y %H:%M:%S,%f}\t" + "\t".join(german(["\t".join(f"{v:.7f}" for v in row)]))
            for i, row in enumerate(hit().rows.T)]  # fmt: skip
    said = ("--variable", "force=Y[0]", "a1=Y[1]", "a2=Y[2]")
    return Known(save(folder, [*facts, "time\tY[0]\tY[1]\tY[2]", *rows]), (hit(),), options=(*DRIVEN, *said))


@case("fifth")
def picoscope(folder: Path) -> Known:
    """PicoScope: names, units in brackets, an empty line; ms and mV; the infinity sign where the range was left."""
    rows = rows_of(hit(), lambda i: f"{1e3 * i / RATE:.8f}")
    rows[70] = rows[70].rpartition(",")[0] + ",∞"
    return Known(save(folder, ["Time,force,a1,a2", "(ms),(N),(m/s²),(m/s²)", "", *rows]), rejected="∞")


@case("fifth")
def tektronix(folder: Path) -> Known:
    """Tektronix: facts in the first columns of the first rows, the samples to the right of them."""
    facts = ["Record Length,1024", "Sample Interval,5.0e-04", "Trigger Point,0", "Vertical Units,N"]
    rows = [f"{facts[i] if i < len(facts) else ','},,{row}" for i, row in enumerate(rows_of(hit()))]
    return Known(save(folder, rows), (hit(),), rejected="(?i)column|number|header")


@case("fifth")
def daqami(folder: Path) -> Known:
    """A number of the sample, date with clock, then the channels: Sample,Date/Time,force (N)."""
    rows = [f"{i},{at(i):%m/%d/%Y %I:%M:%S.%f %p},{row.partition(',')[2]}" for i, row in enumerate(rows_of(hit()))]
    head = "Sample,Date/Time,force (N),a1 (m/s^2),a2 (m/s^2)"
    return Known(save(folder, ["Device: USB-1608", "Rate: 2000 S/s", "", head, *rows]), (hit(),), rejected="(?i)time")


@case("fifth")
def seconds_of_unix(folder: Path) -> Known:
    """Seconds since 1970 with six decimals, named timestamp."""
    rows = rows_of(hit(), lambda i: f"{1774774800 + i / RATE:.6f}")
    return Known(save(folder, ["timestamp,force,a1,a2", *rows]), (hit(),))


@case("fifth")
def nanoseconds_of_unix(folder: Path) -> Known:
    """Whole nanoseconds since 1970, `time [ns]`."""
    rows = rows_of(hit(), lambda i: f"{1774774800000000000 + i * 500000}")
    return Known(save(folder, ["time [ns],force,a1,a2", *rows]), (hit(),), rejected="(?i)ns|digits|times")


@case("fifth")
def artemis(folder: Path) -> Known:
    """Columns of width without times or names, as programs for responses alone read them."""
    rows = ["".join(f"{v:15.6E}" for v in row) for row in hit().rows.T]
    return Known(save(folder, rows, name="case.asc"), (hit(),), options=(*DRIVEN, "--rate", "2000"))


@case("fifth")
def savetxt_of_complex(folder: Path) -> Known:
    """numpy.savetxt of complex numbers: ` (1.000e+00+2.000e+00j)`, the frequency too; columns said."""
    np.savetxt(folder / "case.txt", np.column_stack([LINES, *plain().values]))
    said = ("--columns", "frequency:Hz,a1:m/s^2/N,a2:m/s^2/N")
    return Known(("case.txt",), frf=plain(), options=(*DRIVEN, *said))


@case("fifth")
def long_table(folder: Path) -> Known:
    """One row for each sample of each channel: channel,time,value."""
    rows = [f"{n},{i / RATE:.6f},{v:.7f}" for n, row in zip(NAMES, hit().rows, strict=True) for i, v in enumerate(row)]
    return Known(save(folder, ["channel,time [s],value", *rows]), rejected="(?i)column|number")


@case("fifth")
def transposed(folder: Path) -> Known:
    """One row a channel, its name in front."""
    rows = [n + "," + ",".join(f"{v:.7f}" for v in row) for n, row in
            zip(("time", *NAMES), [hit().time, *hit().rows], strict=True)]  # fmt: skip
    return Known(save(folder, rows), rejected="(?i)row|column|number")


@case("fifth")
def lvm_strings_between(folder: Path) -> Known:
    """LabVIEW: a special block within the header, comments in rows, a date in another form."""
    text = lvm_head() + segment(list(hit().rows), comments={0: "hit at point 1", 5: "ok, 3;4"})
    text.insert(9, "Description\tforce, a1, a2\tof a hit")
    return Known(save_lvm(folder, text), (hit(),))


@case("fifth")
def lvm_velocity_labels(folder: Path) -> Known:
    """LabVIEW with units as it calls them: Newtons and g_n."""
    record = hit()
    text = lvm_head() + segment([record.force, record.a1 / G, record.a2 / G], units=("Newtons", "gn", "g"))
    return Known(save_lvm(folder, text), (record,))


@case("fifth")
def tdms_unit_names(folder: Path) -> Known:
    """TDMS with unit_string `(m/s^2)` and `Newtons`, a description, NI_ArrayColumn."""
    props = waved(NI_ArrayColumn=0, NI_ChannelName="x", description="x")
    props[0] |= {"unit_string": "Newtons"}
    props[1] |= {"unit_string": "(m/s^2)"}
    return Known(save_tdms(folder, whole(list(hit().rows), props)), (hit(),))


@case("fifth")
def uff_small_exponents(folder: Path) -> Known:
    """Dataset 58 with e for E, a plus left out of nothing, trailing blanks, and a blank line between datasets."""
    lines = [line.replace("E+", "e+").replace("E-", "e-") + "   " if "E" in line[:20] else line
             for line in text_58(functions(hit(), double=True))]  # fmt: skip
    return Known(save_uff(folder, ["", *lines, ""]), (hit(),))


@case("fifth")
def uff_binary_little_single(folder: Path) -> Known:
    """58b in single precision after text of 151 and 2411."""
    head = "\n".join(header_151() + nodes_2411([(1, 0.1, 0, 0), (2, 0.3, 0, 0)])) + "\n"
    data = head.encode() + b"".join(binary_58(f) for f in functions(hit()))
    return Known(save_uff(folder, data), (hit(),))


@case("fifth")
def uff_modes_among_records(folder: Path) -> Known:
    """Modes only: 2411 in metres and two datasets 55, complex, with CRLF and trailing blanks."""
    lines = header_151() + nodes_2411([(1, 0.1, 0, 0), (2, 0.3, 0.05, 0)])
    for k, (f0, zeta, phi) in enumerate(MODES, start=1):
        w = 2 * np.pi * f0
        s = complex(-zeta * w, w * np.sqrt(1 - zeta**2))
        lines += shapes_55(k, (s.real, s.imag, 1, 0, 0, 0), {n: (0j, 0j, complex(v)) for n, v in enumerate(phi, 1)})
    files = save_uff(folder, [line + "  " for line in lines], "\r\n")
    return Known(files, check=modes_right, rig=None, options=())


@case("fifth")
def matlab_of_dewesoft(folder: Path) -> Known:
    """Dewesoft's MATLAB export: Data1_time_force and Data1_force, and so on, Sample_rate."""
    content = {"Sample_rate": RATE}
    for name, row in zip(NAMES, hit().rows, strict=True):
        content |= {f"Data1_{name}": row[:, None], f"Data1_time_{name}": hit().time[:, None]}
    scipy.io.savemat(folder / "case.mat", content)
    said = ("--variable", "force=Data1_force", "a1=Data1_a1", "a2=Data1_a2", "time=Data1_time_force")
    return Known(("case.mat",), (hit(),), options=(*DRIVEN, *said))


@case("fifth")
def matlab_array_of_structures(folder: Path) -> Known:
    """An array of structures, one a channel: ch(k).name, ch(k).unit, ch(k).fs, ch(k).data."""
    channels = np.zeros((1, 3), dtype=[(k, "O") for k in ("name", "unit", "fs", "data")])
    for k, (name, unit, row) in enumerate(zip(NAMES, ("N", "g", "g"), hit().rows, strict=True)):
        channels[0, k] = (name, unit, RATE, (row if k == 0 else row / G)[:, None])
    scipy.io.savemat(folder / "case.mat", {"ch": channels})
    return Known(("case.mat",), (hit(),), rejected="(?i)channel|map|variable|array")


@case("fifth")
def npz(folder: Path) -> Known:
    """numpy.savez of time, force, a1, a2."""
    record = hit()
    np.savez(folder / "case.npz", time=record.time, **dict(zip(NAMES, record.rows, strict=True)))
    return Known(("case.npz",), (record,), rejected="(?i)known kind|npz")


@case("fifth")
def workbook(folder: Path) -> Known:
    """An Excel workbook by its first bytes and its ending."""
    with zipfile.ZipFile(folder / "case.xlsx", "w") as written:
        written.writestr("[Content_Types].xml", "<Types/>")
        written.writestr("xl/workbook.xml", "<workbook/>")
    return Known(("case.xlsx",), rejected="(?i)known kind|workbook|excel")


@case("fifth")
def hdf5_with_attributes(folder: Path) -> Known:
    """HDF5: a dataset a channel, each with attributes unit and fs."""
    with h5py.File(folder / "case.h5", "w") as file:
        for name, unit, row in zip(NAMES, ("N", "g", "g"), hit().rows, strict=True):
            file[f"records/{name}"] = row if name == "force" else row / G
            file[f"records/{name}"].attrs.update({"unit": unit, "fs": RATE})
    return Known(("case.h5",), (hit(),), rejected="(?i)campaign|map|rate|unit")


@case("fifth")
def sep_of_several_sensors(folder: Path) -> Known:
    """SEP005: data, name, unit_str and fs, with more fields than it asks for, and times in ISO 8601."""
    series = [
        {"name": n, "data": row.tolist(), "unit_str": u, "fs": int(RATE), "start_timestamp": "2026-03-29T10:00:00Z",
         "location": "x", "sensor": {"id": 3}}
        for n, row, u in zip(NAMES, hit().rows, ("N", "m/s²", "m/s²"), strict=True)
    ]  # fmt: skip
    (folder / "case.json").write_text(json.dumps(series), encoding="utf-8")
    return Known(("case.json",), (hit(),))
