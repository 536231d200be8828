"""A tenth draw, text: measurement files, loggers, telephones and typographic numbers, and FRFs over both halves."""

from pathlib import Path

import numpy as np
from drawn import Drawn, draws
from known import DISPLACEMENT, VELOCITY, G, Known, KnownFrf
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from seventh_table_cases import at, cells, rows_of, slow
from text_cases import save

DRIVEN = ("--drive-point", "1")
HEAD = "time [s],force [N],a1 [m/s^2],a2 [m/s^2]"


@draws("tenth")
def lvm_all_tags(folder: Path, d: Drawn) -> Known:
    """Every optional tag that the specification lists, in the file's header and in the segment's."""
    r = d.hit()
    tags = ["Test_Name\trun\trun\trun", "Test_Numbers\t1\t2\t3", "UUT_Name\tbeam\tbeam\tbeam"]
    tags += ["UUT_M/N\t7\t7\t7", "UUT_S/N\t12\t12\t12", "Y_Dimension\tForce\tAcceleration\tAcceleration"]
    lines = segment(list(r.rows), delta=(1 / d.rate,) * 3)
    file = head()
    file[-2:-2] = ["Project\t12", "Description\tHammer: 1.5 kg, 3 N", "Special\t0"]
    return Known(save_lvm(folder, [*file, lines[0], *tags, *lines[1:]]), (r,))


@draws("tenth")
def lvm_over_midnight(folder: Path, d: Drawn) -> Known:
    """Two segments, the first begins before midnight and the second after it; their X both begin at zero."""
    hits = [d.hit(1), d.hit(2)]
    parts = [segment(list(r.rows), "No", delta=(1 / d.rate,) * 3) for r in hits]
    first = [line.replace("10:00:01.5", "23:59:57.5") for line in parts[0]]
    second = [line.replace("10:00:01.5", "00:00:09.5").replace("2026/03/29", "2026/03/30") for line in parts[1]]
    return Known(save_lvm(folder, [*head(columns="No", multi="Yes"), *first, *second]), tuple(hits))


@draws("tenth")
def iso_basic(folder: Path, d: Drawn) -> Known:
    """Times in the basic format of ISO 8601, without hyphens and colons."""
    d = slow(d)
    r = d.hit()
    rows = rows_of(r, lambda i: f"{at(i, d.rate, '2026-11-28T23:59:59.5'):%Y%m%dT%H%M%S.%f}")
    reason = r"20261128T235959\.5"
    return Known(save(folder, [HEAD.replace("[s]", ""), *rows]), (r,), rejected=reason)


@draws("tenth")
def pandas_nanoseconds(folder: Path, d: Drawn) -> Known:
    """A data frame with an index of dates in nanoseconds and without a name."""
    r = d.hit()

    def times(i: int) -> str:
        whole, part = divmod(round(1e9 * i / d.rate), 10**9)
        return f"{at(whole, 1.0, '2026-11-28T10:00:00'):%Y-%m-%d %H:%M:%S}.{part:09d}"

    return Known(save(folder, [",force,a1,a2", *rows_of(r, times)]), (r,), tolerance=1e-4)


@draws("tenth")
def testing_machine(folder: Path, d: Drawn) -> Known:
    """A servohydraulic controller's text: signs parted by |, facts, names, units `Sec` and `m/Sec^2`, tabs."""
    r = d.hit()
    top = ["MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A", "", "Data Header:\tData Acquisition: Timed", "Station Name:\tbeam.cfg"]
    top += [f"Time:\t{d.n / d.rate:.6f}\tSec\t11/28/2026 10:00:00 AM", "", "Data Acquisition:\tTimed"]
    top += ["Time\tforce\ta1\ta2", "Sec\tkN\tm/Sec^2\tm/Sec^2"]
    rows = rows_of(r, between="\t", factors=(1e-3, 1, 1), digits=9)
    return Known(save(folder, [*top, *rows], ending="\r\n", name="specimen.dat"), (r,))


@draws("tenth")
def mobility_in_decibels_of_nanometres(folder: Path, d: Drawn) -> Known:
    """Mobilities in dB over 1 nm/(s N), and degrees."""
    right = d.frf("mobility")
    parts = [v for h in right.values for v in (20 * np.log10(abs(h) / 1e-9), np.degrees(np.angle(h)))]
    names = ",".join(f"|{n}| [dB re 1e-9 m/s/N],phase {n} [deg]" for n in ("a1", "a2"))
    files = save(folder, ["Frequency [Hz]," + names, *cells(",", right.frequency, *parts)])
    return Known(files, frf=right, rig=VELOCITY, rejected="(?i)dB re|1e-9", tolerance=1e-4)


@draws("tenth")
def receptance_in_radians(folder: Path, d: Drawn) -> Known:
    """Receptances in µm/N with their phase in rad, named by a Greek letter, decimal commas."""
    right = d.frf("receptance")
    parts = [v for h in right.values for v in (1e6 * abs(h), np.angle(h))]
    names = "|a1| [µm/N];φ a1 [rad];|a2| [µm/N];φ a2 [rad]"
    rows = [row.replace(".", ",") for row in cells(";", right.frequency, *parts)]
    return Known(save(folder, ["f [Hz];" + names, *rows]), frf=right, rig=DISPLACEMENT, rejected="φ")


@draws("tenth")
def writetable_complex(folder: Path, d: Drawn) -> Known:
    """A MATLAB table of complex FRFs: 1.5-0.2i in one cell."""
    right = d.frf()
    rows = [
        f"{f:.9g}," + ",".join(f"{v.real:.9g}{v.imag:+.9g}i" for v in h)
        for f, h in zip(right.frequency, right.values.T, strict=True)
    ]
    return Known(save(folder, ["f_Hz,a1,a2", *rows]), frf=right, rejected=r"(?i)complex|\di\b")


@draws("tenth")
def gnuplot_blocks(folder: Path, d: Drawn) -> Known:
    """Two hits as two data sets of one file: # before the names, two blank lines between, times begin again."""
    hits = [d.hit(1), d.hit(2)]
    name = "# time[s] force[N] a1[m/s^2] a2[m/s^2]"
    lines = [name, *rows_of(hits[0], between=" "), "", "", *rows_of(hits[1], between=" ")]
    reason = r"(?i)ascend|begin again|goes back|blank line"
    return Known(save(folder, lines, name="case.dat"), tuple(hits), rejected=reason)


@draws("tenth")
def phyphox(folder: Path, d: Drawn) -> Known:
    """A telephone's application: quoted names with units, exponents, four columns of which three are asked for."""
    r = d.hit()
    names = '"Time (s)","Force (N)","Acceleration x (m/s^2)","Acceleration y (m/s^2)","Absolute acceleration (m/s^2)"'
    rows = cells(",", r.time, *r.rows, np.hypot(r.a1, r.a2))
    said = ("--variable", "force=Force", "a1=Acceleration x", "a2=Acceleration y")
    return Known(save(folder, [names, *rows]), (r,), options=(*DRIVEN, *said))


@draws("tenth")
def gulf_coast_logger(folder: Path, d: Drawn) -> Known:
    """A logger's facts behind semicolons; the last of them, Headers, names the columns."""
    r = d.hit()
    top = [";Title, http://www.example.org, HAM", ";Version, 1112, Build date, Jan 15 2026, SN:CCDC10161000CAC"]
    top += [";Start_time, 2026-11-28, 10:00:00.000", ";Temperature, 23.50, deg C, Vbat, 1420, mv"]
    top += [f";SampleRate, {d.rate:.0f},Hz", ";Deadband, 0, counts", ";Headers, time, force, a1, a2"]
    return Known(save(folder, [*top, *rows_of(r)], ending="\r\n"), (r,), rejected="(?i)names|Headers|--columns")


@draws("tenth")
def hours_minutes_seconds(folder: Path, d: Drawn) -> Known:
    """Time over three columns: h, min, s; the minute changes within the record."""
    d = slow(d)
    r = d.hit()
    rows = rows_of(r, lambda i: f"{at(i, d.rate, '2026-11-28T10:59:59.5'):%H;%M;%S.%f}", ";")
    return Known(save(folder, ["h;min;s;force [N];a1 [m/s²];a2 [m/s²]", *rows]), (r,), rejected=r"(?i)\bmin\b|\bh\b")


@draws("tenth")
def typographic_minus(folder: Path, d: Drawn) -> Known:
    """Negative numbers with the minus of typography, U+2212."""
    r = d.hit()
    return Known(save(folder, [HEAD, *(row.replace("-", "\u2212") for row in rows_of(r))]), (r,), rejected="\u2212")


@draws("tenth")
def thousandths_of_g(folder: Path, d: Drawn) -> Known:
    """Accelerations in mg, which is a thousandth of g and no milligram; the force in kN."""
    r = d.hit()
    rows = rows_of(r, factors=(1e-3, 1e3 / G, 1e3 / G), digits=9)
    return Known(save(folder, ["time [s],force [kN],a1 [mg],a2 [mg]", *rows]), (r,), rejected=r"\bmg\b")


@draws("tenth")
def negative_frequencies(folder: Path, d: Drawn) -> Known:
    """Lines from minus to plus half the rate, as a shifted discrete Fourier transform has them."""
    half = d.frf(lines=np.arange(1, int(d.rate)) * 0.5)
    f = np.r_[-half.frequency[::-1], 0, half.frequency]
    both = [np.r_[h[::-1].conj(), 0, h] for h in half.values]
    names = "f [Hz],a1 re [m/s²/N],a1 im [m/s²/N],a2 re [m/s²/N],a2 im [m/s²/N]"
    files = save(folder, [names, *cells(",", f, both[0].real, both[0].imag, both[1].real, both[1].imag)])
    return Known(files, frf=KnownFrf(half.frequency, half.values), rejected="begin at -")
