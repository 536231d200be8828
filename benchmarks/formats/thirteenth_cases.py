"""A thirteenth draw, text, after files that laboratories have published: analysers, recorders and home-made loggers."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from drawn import Drawn, draws
from known import VELOCITY, G, Known
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from seventh_table_cases import at, cells, rows_of
from tenth_cases import DRIVEN
from text_cases import save

FACTS = ("Analyzer:\tFFT_Spectrum_Averaging", "AnalyzerName:\tFFT Analyzer", "", "Bipolar:\tTrue", "", "Domain:\t1")


def pulse(function: str, kind: str, unit: str, rows: list[str], x: tuple[str, float, float], signal: str) -> list[str]:
    """What PULSE LabShop writes above a function, its empty facts, and rows that are counted from 1."""
    top = [
        "Header Size:\t 34",
        "Pulse Version:\t 80",
        "Running Pulse Version:\tPULSE LabShop v. 15.1.0.15 - 2010-11-08",
    ]
    top += ["Decimal Symbol:\t.", "Date Format:\tdd/MM/yyyy", "Time Format:\tHH:mm:ss:mmm", f"Data Type:\t{kind}"]
    top += ["Slice:\tFalse", "Z-Axis type:\tLinear", "Z-Axis size:\t1", "Z-Axis unit:\t", "X-Axis type:\tLinear"]
    top += [f"X-Axis size:\t{len(rows)}", f"X-Axis unit:\t{x[0]}", f"X-Axis first value:\t {x[1]:.10e}"]
    top += [f"X-Axis delta:\t {x[2]:.10e}", "", f"AmplitudeUnit:\t{unit}", *FACTS, f"Function:\t{function}", ""]
    top += [f"RecordLength:\t {4:.10e}", "Ref_Signal:\tforce", "RefSignalUnit:\tN", f"Signal:\t{signal}"]
    top += [f"Title:\t{function} ({signal}) - Current", "TemplateName:\tWorking", "MeasurementName:\tInput", ""]
    below = ["Z-index:\t \t1", "Date:\t \t15/11/2026", "Time:\t \t11:30:48:681", "Relative time:\t \t 0.00000e+000"]
    lines = [line + "\t \t " if line else "\t \t \t " for line in top] + [line + "\t " for line in below]
    return [*lines, "Z-axis:\t \t 0.0000000000e+000\t ", *(f"{k}\t{row}" for k, row in enumerate(rows, 1))]


def pulse_frf(d: Drawn) -> list[list[str]]:
    right = d.frf()
    x = ("Hz", float(right.frequency[0]), 0.25)
    rows = [[f" {f:.10e}\t{v.real: .6e}\t{v.imag: .6e}" for f, v in zip(right.frequency, h, strict=True)]
            for h in right.values]  # fmt: skip
    names = ("a1", "a2")
    return [pulse(f"Frequency Response H1({name},force)", "Complex", "(m/s²)/N", part, x, name)
            for name, part in zip(names, rows, strict=True)]  # fmt: skip


@draws("thirteenth")
def pulse_two_functions(folder: Path, d: Drawn) -> Known:
    """PULSE LabShop: two FRFs below each other, each with its facts; numbered rows of line, real, imaginary."""
    lines = [line for part in pulse_frf(d) for line in part]
    return Known(save(folder, lines, "cp1252", "\r\n", name="case.txt"), frf=d.frf(), rejected="(?i)--columns|title")


@draws("thirteenth")
def pulse_file_a_function(folder: Path, d: Drawn) -> Known:
    """PULSE LabShop: one file for each FRF."""
    names = [save(folder, part, "cp1252", "\r\n", name=f"case{k}.txt")[0] for k, part in enumerate(pulse_frf(d), 1)]
    return Known(tuple(names), frf=d.frf(), rejected="(?i)one file|every response|a2")


@draws("thirteenth")
def pulse_times(folder: Path, d: Drawn) -> Known:
    """PULSE LabShop: three time functions below each other, numbered rows."""
    r = d.hit()
    lines = []
    for name, unit, row in zip(("force", "a1", "a2"), ("N", "m/s²", "m/s²"), r.rows, strict=True):
        rows = [f" {t:.10e}\t{v: .7e}\t " for t, v in zip(r.time, row, strict=True)]
        lines += pulse("Time", "Real", unit, rows, ("s", 0.0, 1 / d.rate), name)
    return Known(save(folder, lines, "cp1252", "\r\n", name="case.txt"), (r,), rejected="(?i)force|--columns|below")


@draws("thirteenth")
def bk_connect(folder: Path, d: Drawn) -> Known:
    """A CSV as BK Connect imports it: facts, then Name, FunctionType, Unit, OutputDOF, InputDOF, and rows of a time."""
    r = d.hit()
    top = ["CSVFormatType,Time", "SinglePrecision,FALSE", f"DataLength,{d.n}", "First,0", f"Delta,{1 / d.rate:.20f}"]
    top += ["AxisUnit,s", "AxisValueExists,1", "Signals,3", "Date,26/11/2026 10:00:00", "", "Name,force,a1,a2"]
    top += ["FunctionType,StreamedTimeHistory", "Unit,N,m/s^2,m/s^2", "OutputDOF,New DOF.1Z+,New DOF.1Z+,New DOF.2Z+"]
    return Known(save(folder, [*top, "InputDOF" + 3 * ",New DOF.1Z+", *rows_of(r)], ending="\r\n"), (r,))


@draws("thirteenth")
def signal_calc(folder: Path, d: Drawn) -> Known:
    """SignalCalc: `Units: Ratio`, pairs of channels, a unit row `Hz (m/s²)(N)`; two FRFs beside each other."""
    right = d.frf()
    a, b = right.values
    top = ["Units: Ratio", "Ref Chan:Resp Chan\t1-Z:1-Z\t\t1-Z:2-Z\t", "Channel Name\t : \t\t : \t"]
    top += ["Channel Comment\t : \t\t : \t", "", "Frequency\t Real\t Imaginary\t Real\t Imaginary", "", "Units:"]
    top += ["Hz\t(m/s²)(N)\t \t(m/s²)(N)\t "]
    rows = [f"{f:.13e}\t" + "\t".join(f"{v:16.9g}" for v in (x.real, x.imag, y.real, y.imag))
            for f, x, y in zip(right.frequency, a, b, strict=True)]  # fmt: skip
    return Known(save(folder, [*top, *rows], "cp1252", "\r\n", name="case.txt"), frf=right, rejected="(?i)unit|--col")


@draws("thirteenth")
def lvm_slow_and_noted(folder: Path, d: Drawn) -> Known:
    """X from 46.86 s on with six decimals, a note that it holds for the first only; four channels of five samples."""
    r = d.hit()
    slow = [np.full(5, v) for v in (1e5, 4.9e5, -89.2, 0.0)]
    names = ("force", "a1", "a2", "Untitled", "Untitled 1", "Untitled 2", "Untitled 3")
    units, delta = ("N", "m/s^2", "m/s^2", *4 * ("",)), (1 / d.rate,) * 3 + (1.0,) * 4
    x0 = (46.859645800000074,) * 3 + (0.0,) * 4
    lines = segment([*r.rows, *slow], separator=",", x0=x0, delta=delta, units=units, names=names)
    first = next(k for k, line in enumerate(lines) if line.startswith("X_Value")) + 1
    rows = [
        ",".join([f"{46.8596458 + i / d.rate:.6f}", *line.split(",")[1:]]) for i, line in enumerate(lines[first:-1])
    ]
    note = "Notes,X values guaranteed valid only for force,,,,,,"
    return Known(save_lvm(folder, [*head(","), note, *lines[:first], *rows, ""]), (r,))


@draws("thirteenth")
def lvm_thinned(folder: Path, d: Drawn) -> Known:
    """Somebody kept each 16th row: X says so, Delta_X and Samples are those of the whole."""
    r = d.hit()
    lines = segment(list(r.rows), delta=(1 / d.rate,) * 3)
    whole = [line.replace(f"{1 / d.rate:.7E}", f"{1 / d.rate / 16:.7E}").replace(str(d.n), str(16 * d.n))
             if line.startswith(("Delta_X", "Samples")) else line for line in lines]  # fmt: skip
    reason = "(?i)Delta_X|Samples|rate|cut off"
    return Known(save_lvm(folder, [*head(), *whole]), (r,), rejected=reason)


@draws("thirteenth")
def lvm_spectra_as_time(folder: Path, d: Drawn) -> Known:
    """Spectra that LabVIEW saved with X_Dimension Time; only the channels' names say FFT - (RMS)."""
    spectra = [abs(np.fft.rfft(row)) / d.n for row in d.hit().rows]
    step = d.rate / d.n
    names = tuple(f"{n} (FFT - (RMS))" for n in ("force", "a1", "a2"))
    lines = head() + segment(spectra, delta=(step,) * 3, names=names)
    said = ("--variable", *(f"{n.split()[0]}={n}" for n in names))
    return Known(save_lvm(folder, lines), options=(*DRIVEN, *said), rejected="(?i)FFT|spectr|frequenc|rate|times")


@draws("thirteenth")
def catman_text(folder: Path, d: Drawn) -> Known:
    """catman: `Zeit  1 - Standardmessrate [s]`, tabs, decimal commas, facts above; the force called Kraft."""
    r = d.hit()
    top = ["catman", "Version: 5.5.2", "Datei: hit_001.bin", "Start: 26.11.2026 10:00:00", "Anzahl Kanäle: 4", ""]
    names = "Zeit  1 - Standardmessrate [s]\tKraft [N]\ta1 [m/s²]\ta2 [m/s²]"
    rows = [row.replace(".", ",") for row in rows_of(r, between="\t")]
    files = save(folder, [*top, names, *rows], "cp1252", "\r\n", name="case.asc")
    return Known(files, (r,), options=(*DRIVEN, "--variable", "force=Kraft"))


@draws("thirteenth")
def dewesoft_csv(folder: Path, d: Drawn) -> Known:
    """Dewesoft X: facts with colons within quotes, names with units in brackets, a column of words for events."""
    r = d.hit()
    top = ['"File name: hit_0001.dxd"', '"Start time: 11/26/2026 10:00:00.123 AM"', f'"Sample rate: {d.rate:g} Hz"']
    top += ['"Number of channels: 3"', "", '"Time (s)","force (N)","a1 (m/s2)","a2 (m/s2)","Events"']
    rows = [row + (',"Trigger"' if i == 40 else ',""') for i, row in enumerate(rows_of(r))]
    return Known(save(folder, [*top, *rows], "utf-8-sig", "\r\n"), (r,))


@draws("thirteenth")
def testlab_pairs(folder: Path, d: Drawn) -> Known:
    """Testlab to a spreadsheet: each function with an X of its own, Time Hamm:1:+Z, Time Beam:1:+Z ...; units below."""
    r = d.hit()
    top = ["Hamm:1:+Z\t\tBeam:1:+Z\t\tBeam:2:+Z\t", "Time\tforce\tTime\ta1\tTime\ta2", "s\tN\ts\tm/s^2\ts\tm/s^2"]
    rows = ["\t".join(f"{t:.9f}\t{v:.7g}" for v in row) for t, row in zip(r.time, r.rows.T, strict=True)]
    return Known(save(folder, [*top, *rows], name="case.txt"), (r,), rejected="(?i)twice|Time.*(columns|times)")


@draws("thirteenth")
def signal_express(folder: Path, d: Drawn) -> Known:
    """SignalExpress: `channel names:`, `start times:`, `dt:` and `data:` in lines of their own, no times."""
    r = d.hit()
    top = ["channel names:", "force\ta1\ta2", "start times:", "\t".join(3 * ["11/26/2026 10:00:00.123456"])]
    top += ["dt:", "\t".join(3 * [f"{1 / d.rate:.12f}"]), "data:"]
    rows = ["\t".join(f"{v:.7E}" for v in row) for row in r.rows.T]
    return Known(save(folder, [*top, *rows], ending="\r\n", name="case.txt"), (r,), rejected="--rate")


@draws("thirteenth")
def polytec_points(folder: Path, d: Drawn) -> Known:
    """A scanning vibrometer's text: the points' mobilities below each other, units in brackets with blanks."""
    right = d.frf("mobility")
    lines = []
    for k, h in enumerate(right.values, 1):
        lines += [f"Point Index\t{k}", "Component\tRoot Point", "Signal\tVib & Ref1 H1 Velocity / Force", ""]
        lines += ["Frequency\tReal\tImaginary", "[ Hz ]\t[ m/s / N ]\t[ m/s / N ]"]
        lines += [*cells("\t", right.frequency, h.real, h.imag), ""]
    return Known(save(folder, lines, ending="\r\n", name="case.txt"), frf=right, rig=VELOCITY,
                 rejected="(?i)--columns|title|which")  # fmt: skip


@draws("thirteenth")
def matlab_durations(folder: Path, d: Drawn) -> Known:
    """MATLAB's writetimetable: `0.00048828 sec` with five digits."""
    r = d.hit()
    rows = rows_of(r, lambda i: f"{i / d.rate:.5g} sec")
    return Known(save(folder, ["Time,force,a1,a2", *rows]), (r,), rejected=r"(?i)sec\b|digits|time")


@draws("thirteenth")
def spreadsheet_minutes(folder: Path, d: Drawn) -> Known:
    """A spreadsheet saved its view of the times: 00:00.0, minutes, seconds and tenths."""
    r = d.hit()
    rows = rows_of(r, lambda i: f"{at(i, d.rate, '2026-11-26T00:00:00'):%M:%S.%f}"[:7])
    reason = "(?i)digit|resol|coarse|round|same time|even|repeat|rise"
    return Known(save(folder, [",".join(("Time", "force [N]", "a1 [m/s^2]", "a2 [m/s^2]")), *rows]), rejected=reason)


@draws("thirteenth")
def chinese_names(folder: Path, d: Drawn) -> Known:
    """Names in Chinese, encoded as GB18030, said by --columns."""
    r = d.hit()
    files = save(folder, ["时间(s),力(N),加速度1(m/s^2),加速度2(m/s^2)", *rows_of(r)], "gb18030", "\r\n")
    return Known(files, (r,), options=(*DRIVEN, "--columns", "time,force:N,a1:m/s^2,a2:m/s^2"))


@draws("thirteenth")
def sensitivities_above(folder: Path, d: Drawn) -> Known:
    """Channel numbers and sensitivities in rows above the numbers, which are scaled already; decimal commas."""
    r = d.hit()
    top = [
        "Channel;1;2;3",
        "Name;force;a1;a2",
        "Sensitivity [mV/unit];2,27;10,21;9,87",
        "Unit;N;m/s²;m/s²",
        "Time [s];;;",
    ]
    rows = [row.replace(".", ",") for row in rows_of(r, between=";")]
    said = ("--columns", "time,force:N,a1:m/s^2,a2:m/s^2")
    return Known(save(folder, [*top, *rows], "cp1252"), (r,), options=(*DRIVEN, *said))


@draws("thirteenth")
def complex_without_lines(folder: Path, d: Drawn) -> Known:
    """One complex number a line as Python prints it, no frequencies."""
    lines = [f"({v.real!r}{v.imag:+}j)" for v in d.frf().values[0].tolist()]
    return Known(save(folder, lines, name="case.txt"), rejected="(?i)frequenc|line|abscissa|--columns")


@draws("thirteenth")
def serial_monitor(folder: Path, d: Drawn) -> Known:
    """A microcontroller's rows as a terminal saves them: clock, arrow, then microseconds and values."""
    r = d.hit()
    names = "10:00:00.123 -> time_us,force_N,a1_m/s^2,a2_m/s^2"
    rows = [f"{at(i, d.rate, '2026-11-26T10:00:00.125'):%H:%M:%S.%f}"[:12] + f" -> {1e6 * i / d.rate:.3f}" + row
            for i, row in enumerate(rows_of(r, lambda i: ""))]  # fmt: skip
    return Known(save(folder, [names, *rows]), (r,), rejected="->")


@draws("thirteenth")
def units_in_cells(folder: Path, d: Drawn) -> Known:
    """Each cell with its unit: 0.0005 s,1.25 N,0.5 g."""
    d = replace(d, seed=d.seed + 1)
    r = d.hit()
    rows = [f"{t:.9f} s,{f:.7f} N,{a / G:.9f} g,{b / G:.9f} g" for t, (f, a, b) in zip(r.time, r.rows.T, strict=True)]
    return Known(save(folder, ["time,force,a1,a2", *rows]), (r,), rejected=r"\d (s|N|g)\b")
