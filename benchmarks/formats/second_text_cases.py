"""A second draw, after what the first one showed was mended: text files, tables of FRFs, LabVIEW's text files."""

from pathlib import Path

import numpy as np
from clock_cases import at
from frf_cases import LINES, polar
from frf_cases import plain as plain_frf
from frf_cases import save as save_frf
from known import RATE, G, Known, Record, case, hit
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from text_cases import HEAD, comma, lines_of, plain, save, seconds


@case("second text")
def fractions_left_out(folder: Path) -> Known:
    """ISO times as Python writes them: without a fraction where it is zero."""
    record = hit()
    rows = lines_of(record, lambda i: at(i).replace(tzinfo=None).isoformat(), plain, ",")
    return Known(save(folder, ["time,force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), (record,))


@case("second text")
def date_and_clock_columns(folder: Path) -> Known:
    """Date and clock in two columns, decimal comma."""
    record = hit()
    rows = lines_of(record, lambda i: f"{at(i):%d.%m.%Y;%H:%M:%S},{at(i).microsecond:06d}", comma, ";")
    return Known(save(folder, ["Datum;Uhrzeit;force [N];a1 [m/s^2];a2 [m/s^2]", *rows]), (record,))


@case("second text")
def quantity_over_unit(folder: Path) -> Known:
    """Headings as ISO 80000 writes them, `force/kN`."""
    record = hit()
    rows = [f"{i / RATE:.4f};{f / 1e3:.9f};{a / G:.8f};{b:.6f}" for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(save(folder, ["t/s;force/kN;a1/g;a2/(m/s²)", *rows]), (record,))


@case("second text")
def quoted_thousands(folder: Path) -> Known:
    """`"1,234.500"` in quotes between commas."""
    record = hit()
    rows = [f'{i / RATE:.4f},"{1e3 * f:,.3f}","{a:,.6f}","{b:,.6f}"' for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(save(folder, [HEAD.replace("[N]", "[mN]"), *rows]), (record,))


@case("second text")
def time_column_last(folder: Path) -> Known:
    """The column of times is the last, in µs."""
    record = hit()
    rows = [f"{f:.6f}, {a:+.6f}, {b:+.6E}, {1e6 * i / RATE:.0f}" for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(save(folder, ["force [N], a1 [m/s^2], a2 [m/s^2], time [µs]", *rows]), (record,))


@case("second text")
def hours(folder: Path) -> Known:
    """Times in hours."""
    rows = lines_of(hit(), lambda i: f"{i / RATE / 3600:.12f}", plain, ",")
    return Known(save(folder, [HEAD.replace("[s]", "[h]"), *rows]), (hit(),), rejected="(?i)'h' is no unit of time")


@case("second text")
def two_columns_of_one_name(folder: Path) -> Known:
    """Two columns are called a1."""
    rows = lines_of(hit(), seconds, plain, ",")
    head_ = "time [s],force [N],a1 [m/s^2],a1 [m/s^2]"
    return Known(save(folder, [head_, *rows]), rejected="(?i)a1.*twice|no column for channel a2")


@case("second text")
def summary_below(folder: Path) -> Known:
    """Lines of a summary below the rows."""
    rows = [*lines_of(hit(), seconds, plain, ","), "Max,1,2,3", "Min,-1,-2,-3"]
    return Known(save(folder, [HEAD, *rows]), (hit(),), rejected="(?i)line 102[67].*Max|Max.*line 102[67]")


@case("second text")
def two_hits_in_one_table(folder: Path) -> Known:
    """The times begin again at 0 after the first hit."""
    rows = [*lines_of(hit(1), seconds, plain, ","), *lines_of(hit(2), seconds, plain, ",")]
    return Known(save(folder, [HEAD, *rows]), (hit(1), hit(2)), rejected="(?i)does not ascend")


@case("second text")
def two_headers_in_one_table(folder: Path) -> Known:
    """A second header and a second hit below an empty line."""
    rows = [*lines_of(hit(1), seconds, plain, ","), "", HEAD, *lines_of(hit(2), seconds, plain, ",")]
    return Known(save(folder, [HEAD, *rows]), (hit(1), hit(2)), rejected=r"(?i)line 102[6-8]|does not ascend|several")


@case("second text")
def scattered_times(folder: Path) -> Known:
    """Times of a logger's own clock that jitter by a fifth of a step."""
    late = np.random.default_rng(3).uniform(-0.2, 0.2, 1024)
    rows = lines_of(hit(), lambda i: f"{(i + late[i]) / RATE:.7f}", plain, ",")
    return Known(save(folder, [HEAD, *rows]), rejected="(?i)uneven")


@case("second text")
def real_parts_first(folder: Path) -> Known:
    """All real parts, then all imaginary parts."""
    right = plain_frf()
    columns = [LINES, *(h.real for h in right.values), *(h.imag for h in right.values)]
    return Known(save_frf(folder, ["Frequency [Hz],a1 Re,a2 Re,a1 Im,a2 Im"], columns), frf=right)


@case("second text")
def per_pound(folder: Path) -> Known:
    """Magnitudes in g/lbf, phases in degrees."""
    right = plain_frf()
    factor = 4.4482216152605 / G
    (m1, p1), (m2, p2) = (polar(h * factor) for h in right.values)
    head_ = "Frequency [Hz],a1 Mag [g/lbf],a1 Phase [deg],a2 Mag [g/lbf],a2 Phase [deg]"
    return Known(save_frf(folder, [head_], [LINES, m1, p1, m2, p2]), frf=right)


@case("second text")
def decibels_of_a_millionth(folder: Path) -> Known:
    """Levels that refer to 1e-6 m/s^2/N."""
    right = plain_frf()
    (m1, p1), (m2, p2) = (polar(h * 1e6) for h in right.values)
    unit = "[dB re 1e-6 m/s^2/N]"
    head_ = f"Frequency [Hz],a1 Mag {unit},a1 Phase [deg],a2 Mag {unit},a2 Phase [deg]"
    columns = [LINES, 20 * np.log10(m1), p1, 20 * np.log10(m2), p2]
    return Known(save_frf(folder, [head_], columns), frf=right, rejected="dB re 1e-6")


@case("second text")
def phase_in_turns(folder: Path) -> Known:
    """A phase without a unit."""
    right = plain_frf()
    (m1, p1), (m2, p2) = (polar(h) for h in right.values)
    head_ = "Frequency [Hz],a1 Mag,a1 Phase,a2 Mag,a2 Phase"
    return Known(save_frf(folder, [head_], [LINES, m1, p1 / 360, m2, p2 / 360]), rejected="(?i)phase")


@case("second text")
def lvm_fast_with_coarse_x(folder: Path) -> Known:
    """500 kHz; the column of x has six decimals, Delta_X says 2E-6."""
    record = hit(n=4096, rate=500e3)
    lines = segment(list(record.rows), delta=(2e-6,) * 3)
    first = next(k for k, line in enumerate(lines) if line.startswith("X_Value")) + 1
    rows = [f"{2e-6 * k:.5f}\t" + line.split("\t", 1)[1] for k, line in enumerate(lines[first:-1])]
    return Known(save_lvm(folder, head() + lines[:first] + rows), (record,))


@case("second text")
def lvm_lost_samples(folder: Path) -> Known:
    """Twenty rows are missing in the middle; the column of x shows it."""
    lines = segment(list(hit().rows))
    return Known(save_lvm(folder, head() + lines[:400] + lines[420:]), rejected="(?i)uneven|lost|missing|Samples")


@case("second text")
def lvm_cut(folder: Path) -> Known:
    """The file ends after half of the rows; its header says how many there are."""
    lines = segment(list(hit().rows), "No")
    return Known(save_lvm(folder, head(columns="No") + lines[:500]), rejected="(?i)cut|1024|Samples")


def joined(one: Record, two: Record) -> Record:
    return Record(*np.hstack([one.rows, two.rows]))


@case("second text")
def lvm_runs_on(folder: Path) -> Known:
    """One header, two writes, x runs on: one record."""
    whole = joined(hit(1), hit(2))
    lines = [line.replace("2048\t2048\t2048", "1024\t1024\t1024") for line in segment(list(whole.rows))]
    return Known(save_lvm(folder, head() + lines), (whole,))
