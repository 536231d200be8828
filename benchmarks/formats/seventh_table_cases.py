"""The seventh draw's text files: exports of programs, clocks, odd cells, and tables of FRFs."""

import datetime as dt
from pathlib import Path

import numpy as np
from drawn import Drawn, draws, modes
from known import G, Known, Record
from text_cases import save

DRIVEN = ("--drive-point", "1")
LBF, INCH = 4.4482216152605, 0.0254


def rows_of(r: Record, time=None, between=",", factors=(1, 1, 1), digits=7) -> list[str]:
    time = time or (lambda i: f"{i / r.rate:.9f}")
    return [
        between.join([time(i), *(f"{v:.{digits}f}" for v in row * np.array(factors))]) for i, row in enumerate(r.rows.T)
    ]


def cells(between: str, *columns: np.ndarray) -> list[str]:
    return [between.join(f"{v:.9g}" for v in row) for row in np.array(columns).T]


def at(i: int, rate: float, start: str) -> dt.datetime:
    return dt.datetime.fromisoformat(start) + dt.timedelta(microseconds=round(1e6 * i / rate))


def slow(d: Drawn) -> Drawn:
    """With a step that a clock of microseconds writes whole."""
    rate = float(1e6 / round(1e6 / d.rate))
    return Drawn(d.modes, rate, d.n, d.seed)


@draws("seventh")
def me_scope(folder: Path, d: Drawn) -> Known:
    """A data block of ME'scope as text: Y Axis Units a trace, Y Axis DOFs 1Z:1Z and 2Z:1Z above the numbers."""
    right = d.frf()
    a, b = right.values / G
    head = ["Measurement Type\tFRF", "Label\ta case", "X Axis Spacing\tUniform", "X Axis Units\tHz"]
    head += ["Y Axis Type\tReal/Imaginary", "Measurement Label\tM#1\t\tM#2\t", "Y Axis Units\tg/N\t\tg/N\t"]
    head += ["Y Axis DOFs\t1Z:1Z\t\t2Z:1Z\t", ""]
    rows = cells("\t", right.frequency, a.real, a.imag, b.real, b.imag)
    return Known(save(folder, [*head, *rows], name="case.txt"), frf=right, rejected="--columns")


@draws("seventh")
def dewesoft_text(folder: Path, d: Drawn) -> Known:
    """Dewesoft's text export: a block of facts, then names, then units, tabs, decimal comma."""
    r = d.hit()
    head = ["Data information", "Start time\t29.3.2026 10:00:00,123", f"Sample rate\t{d.rate:.1f}".replace(".", ",")]
    head += ["Channels\t3", "", "Data1", "Time\tforce\ta1\ta2", "s\tN\tm/s²\tm/s²"]
    rows = [row.replace(".", ",") for row in rows_of(r, between="\t")]
    return Known(save(folder, [*head, *rows], "cp1252", "\r\n", name="case.txt"), (r,))


@draws("seventh")
def diadem_labels(folder: Path, d: Drawn) -> Known:
    """A first column of labels, empty beside the numbers: Name;Unit;Length, then rows that begin with a semicolon."""
    r = d.hit()
    head = [
        "Name;Time;force;a1;a2",
        "Unit;s;N;m/s^2;m/s^2",
        f"Length;{d.n};{d.n};{d.n};{d.n}",
        "Display;real;real;real;real",
    ]
    rows = [";" + row for row in rows_of(r, between=";")]
    return Known(save(folder, [*head, *rows]), (r,), rejected="--columns")


@draws("seventh")
def head_acoustics(folder: Path, d: Drawn) -> Known:
    """Facts `Abscissa: t/s` and `Ch 1: force/N`, blanks between the columns, no line of names; said by the user."""
    r = d.hit()
    head = [
        "Version: 1",
        "Abscissa: t/s",
        "Ch 1: force/N",
        "Ch 2: a1/(m/s^2)",
        "Ch 3: a2/(m/s^2)",
        f"Values: {d.n}",
        "",
    ]
    said = ("--columns", "time:s,force:N,a1:m/s^2,a2:m/s^2")
    rows = rows_of(r, between="   ")
    return Known(save(folder, [*head, *rows], name="case.asc"), (r,), options=(*DRIVEN, *said))


@draws("seventh")
def catman(folder: Path, d: Drawn) -> Known:
    """A line of names, one of units in square brackets, decimal comma, a tab at the end of each row."""
    r = d.hit()
    head = ["HBM_CATMAN_DATAFILE", "T0 = 29.03.2026 10:00:00", "", "Time 1\tforce\ta1\ta2", "[s]\t[N]\t[m/s2]\t[m/s2]"]
    rows = [row.replace(".", ",") + "\t" for row in rows_of(r, between="\t")]
    said = ("--variable", "time=Time 1")
    return Known(save(folder, [*head, *rows], name="case.asc"), (r,), options=(*DRIVEN, *said))


@draws("seventh")
def crystal_instruments(folder: Path, d: Drawn) -> Known:
    """Facts as `key,value`, then `Frequency (Hz),H(a1,force) Magnitude ((m/s²)/N),H(a1,force) Phase (Degree)`."""
    right = d.frf()
    head = ["Test Name,Impact", "Averages,5", f"Sampling Rate,{d.rate:g}", ""]
    names = [f"H({n},force) {part}" for n in ("a1", "a2") for part in ("Magnitude ((m/s²)/N)", "Phase (Degree)")]
    head.append("Frequency (Hz)," + ",".join(f'"{n}"' for n in names))
    parts = [v for h in right.values for v in (abs(h), np.degrees(np.angle(h)))]
    return Known(save(folder, [*head, *cells(",", right.frequency, *parts)]), frf=right)


@draws("seventh")
def clock_without_date_at_midnight(folder: Path, d: Drawn) -> Known:
    """11:59:59.500000 PM to 12:00:00.000000 AM, without a date."""
    d = slow(d)
    r = d.hit()
    rows = rows_of(r, lambda i: at(i, d.rate, "2026-03-29T23:59:59.5").strftime("%I:%M:%S.%f %p"))
    return Known(save(folder, ["Time,force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), (r,), tolerance=1e-4)


@draws("seventh")
def iso_of_dotnet(folder: Path, d: Drawn) -> Known:
    """Seven decimals and a Z, semicolons."""
    d = slow(d)
    r = d.hit()
    rows = rows_of(r, lambda i: at(i, d.rate, "2026-12-31T23:59:59.9").isoformat(timespec="microseconds") + "0Z", ";")
    return Known(save(folder, ["Timestamp;force (N);a1 (m/s²);a2 (m/s²)", *rows]), (r,))


@draws("seventh")
def clock_set_back(folder: Path, d: Drawn) -> Known:
    """Summer time ends in the middle: the clock goes back by an hour."""
    d = slow(d)
    rows = rows_of(
        d.hit(),
        lambda i: at(i, d.rate, f"2026-10-25T0{2 if i < 900 else 1}:59:59").isoformat(sep=" ", timespec="microseconds"),
    )
    return Known(save(folder, ["Time,force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), rejected="(?i)back|times|ascend")


@draws("seventh")
def quoted_line_ends(folder: Path, d: Drawn) -> Known:
    """Headings in quotes with a line end within, as spreadsheets write wrapped cells."""
    r = d.hit()
    head = '"Time\n[s]","force\n[N]","a1\n[m/s²]","a2\n[m/s²]"'
    return Known(save(folder, [head, *rows_of(r)]), (r,))


@draws("seventh")
def quotes_where_needed(folder: Path, d: Drawn) -> Known:
    """Commas between columns; only cells with a decimal comma are quoted, whole numbers are not."""
    r = d.hit()
    cell = lambda v: f'"{v}"'.replace(".", ",") if "." in v else v  # noqa: E731
    rows = [",".join(cell(f"{float(v):.9g}") for v in row.split(",")) for row in rows_of(r, digits=9)]
    return Known(save(folder, ["time [s],force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), (r,))


@draws("seventh")
def exponents_of_three_digits(folder: Path, d: Drawn) -> Known:
    """Blanks of width, E+000 and E-002 as Windows wrote them, m·s⁻² in UTF-16 big-endian."""
    r = d.hit()
    sci = lambda v: f"{v:.8E}".replace("E+", "E+0").replace("E-", "E-0")  # noqa: E731
    rows = ["\t".join(sci(v) for v in (i / d.rate, *row)) for i, row in enumerate(r.rows.T)]
    head = "time (s)\tforce (N)\ta1 (m·s⁻²)\ta2 (m·s⁻²)"
    return Known(save(folder, [head, *rows], "utf-16"), (r,), rejected="m·s")


@draws("seventh")
def ragged_slow_channel(folder: Path, d: Drawn) -> Known:
    """A slow channel has a cell in each tenth row; the others end before it, without separators."""
    r = d.hit()
    rows = [row + (f";{20 + i / 1e4:.2f}" if i % 10 == 0 else "") for i, row in enumerate(rows_of(r, between=";"))]
    head = "time [s];force [N];a1 [m/s^2];a2 [m/s^2];temp [°C]"
    return Known(save(folder, [head, *rows]), (r,), rejected="(?i)temp|columns")


@draws("seventh")
def group_row_above(folder: Path, d: Drawn) -> Known:
    """A row of merged cells above the names: Hammer,,Accelerometers; names and units as t/s and a1/(m/s²)."""
    r = d.hit()
    head = [",Hammer,Accelerometers,", "t/s,force/N,a1/(m/s²),a2/(m/s²)"]
    return Known(save(folder, [*head, *rows_of(r)]), (r,))


@draws("seventh")
def mobility_of_inches(folder: Path, d: Drawn) -> Known:
    """Mobilities in (in/s)/lbf, real and imaginary, no rig."""
    right = d.frf("mobility")
    parts = [v for h in right.values * LBF / INCH for v in (h.real, h.imag)]
    head = "Frequency [Hz]," + ",".join(f"{p} H{k}_1 [(in/s)/lbf]" for k in (1, 2) for p in ("Re", "Im"))
    return Known(save(folder, [head, *cells(",", right.frequency, *parts)]), check=modes(d), rig=None, options=())


@draws("seventh")
def receptance_in_decibels(folder: Path, d: Drawn) -> Known:
    """Receptances in dB re 1 m/N, phases unwrapped in rad below -2 pi, no rig."""
    right = d.frf("receptance")
    parts = [v for h in right.values for v in (20 * np.log10(abs(h)), np.unwrap(np.angle(h)) - 2 * np.pi)]
    head = "f [Hz];" + ";".join(f"{p}" for k in (1, 2) for p in (f"Mag p{k}/p1 [dB re 1 m/N]", f"Phase p{k}/p1 [rad]"))
    return Known(save(folder, [head, *cells(";", right.frequency, *parts)]), check=modes(d), rig=None, options=())


@draws("seventh")
def apparent_mass(folder: Path, d: Drawn) -> Known:
    """N/(m/s²): a force over an acceleration is no inertance."""
    right = d.frf()
    parts = [v for h in 1 / right.values for v in (h.real, h.imag)]
    head = "f [Hz],Re a1 [N/(m/s^2)],Im a1 [N/(m/s^2)],Re a2 [N/(m/s^2)],Im a2 [N/(m/s^2)]"
    return Known(save(folder, [head, *cells(",", right.frequency, *parts)]), rejected=r"N/\(m/s|inver|unit")


@draws("seventh")
def cycles_per_minute(folder: Path, d: Drawn) -> Known:
    """Lines in CPM, phases from 0 to 360 degrees."""
    right = d.frf()
    parts = [v for h in right.values for v in (abs(h), np.degrees(np.angle(h)) % 360)]
    head = "Frequency [CPM],Mag a1 [m/s^2/N],Phase a1 [deg],Mag a2 [m/s^2/N],Phase a2 [deg]"
    rows = cells(",", right.frequency * 60, *parts)
    return Known(save(folder, [head, *rows]), frf=right, rejected="(?i)cpm")
