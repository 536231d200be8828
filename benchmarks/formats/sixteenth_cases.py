"""A sixteenth draw, text, after exports of recorders, telephones, physiology and simulation; the readers were known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from drawn import Drawn, draws
from known import DISPLACEMENT, PLAIN, Known, KnownFrf
from seventh_table_cases import at, cells, rows_of
from tenth_cases import DRIVEN
from text_cases import save

VOLTS = PLAIN.replace(", point", ", sensitivity_v_per_unit: 0.01, point")
ONE = PLAIN.replace("- {index: 1, name: a1, quantity: acceleration, unit: m/s^2, point: 1}\n", "")
ONE = ONE.replace("index: 2", "index: 1")
"""With the second response alone."""


@draws("sixteenth")
def saleae(folder: Path, d: Drawn) -> Known:
    """A logic analyser's analog channels: `Time [s],Channel 0,Channel 1,Channel 2`, in V."""
    r = d.hit()
    rows = rows_of(r, factors=(0.01,) * 3, digits=9)
    said = ("--variable", "force=Channel 0", "a1=Channel 1", "a2=Channel 2", "--volts")
    files = save(folder, ["Time [s],Channel 0,Channel 1,Channel 2", *rows])
    return Known(files, (r,), options=(*DRIVEN, *said), rig=VOLTS)


@draws("sixteenth")
def keysight(folder: Path, d: Drawn) -> Known:
    """`x-axis,1,2,3`, then `second,Volt,Volt,Volt`; numbers with signs and exponents, times from before the trigger."""
    r = d.hit()
    rows = [",".join([f"{t - 0.02:+.9E}", *(f"{0.01 * v:+.8E}" for v in row)])
            for t, row in zip(r.time, r.rows.T, strict=True)]  # fmt: skip
    said = ("--variable", "force=1", "a1=2", "a2=3")
    files = save(folder, ["x-axis,1,2,3", "second,Volt,Volt,Volt", *rows])
    return Known(files, (r,), options=(*DRIVEN, *said), rig=VOLTS, rejected="--columns")


@draws("sixteenth")
def andro_sensor(folder: Path, d: Drawn) -> Known:
    """`Time since start in ms` in the middle, and a last column of dates as 2026-11-26 10-00-00_123."""
    d = replace(d, rate=2000.0)
    r = d.hit()
    rows = [";".join([*(f"{v:.7f}" for v in row), f"{1e3 * i / d.rate:.1f}",
                      f"{at(i, d.rate, '2026-11-26T10:00:00'):%Y-%m-%d %H-%M-%S_%f}"[:-3]])
            for i, row in enumerate(r.rows.T)]  # fmt: skip
    top = "force (N);a1 (m/s²);a2 (m/s²);Time since start in ms ;YYYY-MO-DD HH-MI-SS_SSS"
    return Known(save(folder, [top, *rows]), (r,))


@draws("sixteenth")
def universal_testing_machine(folder: Path, d: Drawn) -> Known:
    """Names in quotes, below them units in quotes and brackets: "(s)","(kN)","(mm)","(mm)"; displacements."""
    r = d.hit(derivatives=0)
    top = ['"Results Table 1"', "", '"Time","Load","Disp 1","Disp 2"', '"(s)","(kN)","(mm)","(mm)"']
    rows = [f'"{t:.9f}","{f / 1e3:.9f}","{1e3 * a:.12g}","{1e3 * b:.12g}"'
            for t, (f, a, b) in zip(r.time, r.rows.T, strict=True)]  # fmt: skip
    said = ("--variable", "force=Load", "a1=Disp 1", "a2=Disp 2")
    return Known(save(folder, [*top, *rows]), (r,), options=(*DRIVEN, *said), rig=DISPLACEMENT)


@draws("sixteenth")
def open_signals(folder: Path, d: Drawn) -> Known:
    """# and JSON with the rate, # EndOfHeader, then nSeq, DI and the channels behind tabs; names and rate are said."""
    r = d.hit()
    top = ["# OpenSignals Text File Format. Version 1", '# {"00:07:80": {"sampling rate": 1000, "column": ["nSeq"]}}']
    rows = [f"{i % 16}\t0\t" + "\t".join(f"{v:.7f}" for v in row) for i, row in enumerate(r.rows.T)]
    said = ("--columns", ",,force:N,a1:m/s^2,a2:m/s^2", "--rate", f"{d.rate!r}")
    return Known(save(folder, [*top, "# EndOfHeader", *rows], name="case.txt"), (r,), options=(*DRIVEN, *said))


@draws("sixteenth")
def lab_chart(folder: Path, d: Drawn) -> Known:
    """Interval=, ExcelDateTime=, TimeFormat=, ChannelTitle=, Range= and UnitName= before rows of a time and values."""
    r = d.hit()
    top = [f"Interval=\t{1 / d.rate:.12g} s", "ExcelDateTime=\t4.6352416666666666e+04\t26/11/2026 10:00:00.00000"]
    top += ["TimeFormat=\tStartOfBlock", "DateFormat=\t", "ChannelTitle=\tforce\ta1\ta2"]
    top += ["Range=\t100.0 N\t50.0 m/s²\t50.0 m/s²", "UnitName=\tN\tm/s²\tm/s²", "TopValue=\t*\t*\t*"]
    return Known(save(folder, [*top, *rows_of(r, between="\t")], ending="\r\n", name="case.txt"), (r,),
                 rejected="--columns")  # fmt: skip


@draws("sixteenth")
def acq_knowledge(folder: Path, d: Drawn) -> Known:
    """A step, a name and a unit of each channel in a line, msec,CH1,CH2,CH3, a line of counts, then rows."""
    r = d.hit()
    top = ["hit_001.acq", f"{1e3 / d.rate:.9g} msec/sample", "3 channels", "force", "N", "a1", "m/s^2", "a2", "m/s^2"]
    top += ["msec,CH1,CH2,CH3,", f",{d.n},{d.n},{d.n},"]
    rows = [row + "," for row in rows_of(r, lambda i: f"{1e3 * i / d.rate:.9f}")]
    said = ("--variable", "force=CH1", "a1=CH2", "a2=CH3")
    return Known(save(folder, [*top, *rows], name="case.txt"), (r,), options=(*DRIVEN, *said), rejected="--columns")


@draws("sixteenth")
def pairs_of_x(folder: Path, d: Drawn) -> Known:
    """X[s] before each channel, with the same times in each."""
    r = d.hit()
    rows = [",".join(f"{t:.9f},{v:.7f}" for v in row) for t, row in zip(r.time, r.rows.T, strict=True)]
    top = 'X[s],"force","X[s]","a1","X[s]","a2"'
    return Known(save(folder, [top, *rows]), (r,), rejected="(?i)--columns|X")


@draws("sixteenth")
def qualisys_analog(folder: Path, d: Drawn) -> Known:
    """NO_OF_SAMPLES, FREQUENCY, CHANNEL_NAMES with a name for each column; no times."""
    r = d.hit()
    top = [
        f"NO_OF_SAMPLES\t{d.n}",
        "TOT_NO_OF_CHAN\t3",
        f"FREQUENCY\t{d.rate:g}",
        "TIME_STAMP\t2026-11-26, 10:00:00.000",
    ]
    top += ["DATA_INCLUDED\tANALOG", "CHANNEL_NAMES\tforce\ta1\ta2"]
    rows = ["\t".join(f"{v:.7f}" for v in row) for row in r.rows.T]
    return Known(save(folder, [*top, *rows], name="case.tsv"), (r,), rejected="--rate|--columns")


@draws("sixteenth")
def absolute_and_argument(folder: Path, d: Drawn) -> Known:
    """H11_abs and H11_arg behind semicolons, the argument in rad, decimal commas."""
    right = d.frf()
    a, b = right.values
    top = "freq [Hz];H11_abs [m/s^2/N];H11_arg [rad];H21_abs [m/s^2/N];H21_arg [rad]"
    rows = cells(";", right.frequency, abs(a), np.angle(a), abs(b), np.angle(b))
    return Known(save(folder, [top, *(row.replace(".", ",") for row in rows)]), frf=right)


@draws("sixteenth")
def finite_elements_complex(folder: Path, d: Drawn) -> Known:
    """Comments behind %, the last of which names freq (Hz) and functions with units; complex numbers with i."""
    right = d.frf()
    top = [
        "% Model:              beam.mph",
        "% Version:            6.2",
        "% Dimension:          0",
        "% Nodes:              1",
    ]
    top += ["% freq (Hz)                a1 (m/s^2/N)             a2 (m/s^2/N)"]
    rows = ["".join([f"{f:<25.12g}", *(f"{v.real:.10g}{v.imag:+.10g}i".ljust(50) for v in at_line)])
            for f, at_line in zip(right.frequency, right.values.T, strict=True)]  # fmt: skip
    return Known(save(folder, [*top, *rows], name="case.txt"), frf=right)


@draws("sixteenth")
def circuit_simulator(folder: Path, d: Drawn) -> Known:
    """Freq. and (level in dB, phase in degrees) within one cell: (-3.2dB,12.3°)."""
    right = d.frf()
    h = right.values[1]
    rows = [f"{f:.9e}\t({20 * np.log10(abs(v)):.12g}dB,{np.angle(v, deg=True):.12g}°)"
            for f, v in zip(right.frequency, h, strict=True)]  # fmt: skip
    files = save(folder, ["Freq.\tV(a2)", *rows], "cp1252", name="case.txt")
    return Known(files, frf=KnownFrf(right.frequency, h[None]), rig=ONE, rejected=r"(?i)dB|no number|words|--columns",
                 check=lambda folder: "")  # fmt: skip


@draws("sixteenth")
def harmonic_response(folder: Path, d: Drawn) -> Known:
    """FREQ, AMPL, PHASE of one response to 1 N, in m/s^2 alone: no FRF's unit."""
    right = d.frf()
    h = right.values[1]
    top = "FREQ [Hz],AMPL [m/s^2],PHASE [deg]"
    files = save(folder, [top, *cells(",", right.frequency, abs(h), np.angle(h, deg=True))])
    return Known(files, rig=ONE, rejected=r"(?i)m/s\^2")


@draws("sixteenth")
def tracer(folder: Path, d: Drawn) -> Known:
    """Facts with colons, `Sampling Interval: ... Seconds`, then Time (Sec) and the channels."""
    r = d.hit()
    top = ["TracerDAQ PRO", "Channels: 3", f"Sampling Interval: {1 / d.rate:.12g} Seconds", f"Total Samples: {d.n}", ""]
    top += ["Sample,Time (Sec),force (N),a1 (m/s2),a2 (m/s2)"]
    rows = [f"{i},{row}" for i, row in enumerate(rows_of(r), 1)]
    return Known(save(folder, [*top, *rows]), (r,))


@draws("sixteenth")
def physics_toolbox(folder: Path, d: Drawn) -> Known:
    """Clock times to the millisecond with semicolons, where the rate needs more digits."""
    d = replace(d, rate=4096.0)
    r = d.hit()
    rows = [
        row.replace(".", ",")
        for row in rows_of(r, lambda i: f"{at(i, d.rate, '2026-11-26T10:00:00'):%H:%M:%S:%f}"[:-3], ";")
    ]
    reason = "(?i)digit|resol|coarse|round|same time|even|repeat|rise|ascend"
    return Known(save(folder, ["time;force;a1;a2", *rows]), (r,), rejected=reason)


@draws("sixteenth")
def network_analyser(folder: Path, d: Drawn) -> Known:
    """Magnitudes of two channels in dB, and the phase of the second alone."""
    right = d.frf()
    a, b = right.values
    top = "Frequency (Hz),Channel 1 Magnitude (dB),Channel 2 Magnitude (dB),Channel 2 Phase (deg)"
    rows = cells(",", right.frequency, 20 * np.log10(abs(a)), 20 * np.log10(abs(b)), np.angle(b, deg=True))
    return Known(save(folder, [top, *rows]), rejected="(?i)phase|Channel 1|no response")


@draws("sixteenth")
def punch_file(folder: Path, d: Drawn) -> Known:
    """Nastran's punch file of frequency responses: $ lines and continued rows of six numbers."""
    right = d.frf()
    lines = [
        "$TITLE   = BEAM",
        "$ACCELERATION",
        "$MAGNITUDE-PHASE OUTPUT",
        "$POINT ID =           1  IDENTIFIED BY FREQUENCY",
    ]
    for f, v in zip(right.frequency, right.values[0], strict=True):
        lines += [f"{f:16.6E} G {0:16.6E}{0:18.6E}{abs(v):18.6E}", f"-CONT-{' ' * 18}{0:18.6E}{0:18.6E}{0:18.6E}"]
    return Known(save(folder, lines, name="case.pch"), rejected="(?i)known|columns|words|table|header")


@draws("sixteenth")
def room_acoustics(folder: Path, d: Drawn) -> Known:
    """Comments behind *, the last naming Freq(Hz), SPL(dB) and Phase(degrees): a level re 20 uPa is no FRF."""
    right = d.frf()
    h = right.values[1]
    top = ["* Measurement data measured by REW V5.20", "* Source: mic", "* Freq(Hz), SPL(dB), Phase(degrees)"]
    rows = cells(" ", right.frequency, 94 + 20 * np.log10(abs(h)), np.angle(h, deg=True))
    return Known(save(folder, [*top, *rows], name="case.txt"), rig=ONE, rejected="(?i)SPL|response|unit|dB")
