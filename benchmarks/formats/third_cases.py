"""A third draw: what a file says of its axes, its units and its marks where a reader may overlook it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy.io
from clock_cases import at
from known import RATE, G, Known, KnownFrf, case, hit, inertance
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from sep005_cases import listed
from sep005_cases import save as save_sep
from tdms_cases import save as save_tdms
from tdms_cases import waved, whole
from text_cases import comma, german, save
from uff_cases import LINES, frfs, functions
from uff_cases import save as save_uff
from uff_written import SI, text_58, units_164


@case("third")
def units_in_a_comment(folder: Path) -> Known:
    """Names and units in two comment lines, `% time force a1 a2` and `% s N g g`."""
    record = hit()
    rows = [f"{i / RATE:.5f} {f:.6f} {a / G:.8f} {b / G:.8f}" for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(
        save(folder, ["% time force a1 a2", "% s N g g", *rows], name="case.txt"), (record,), rejected="header"
    )


@case("third")
def units_above_the_names(folder: Path) -> Known:
    """The line of units stands above that of the names."""
    record = hit()
    rows = [f"{1e3 * i / RATE:.2f};{f / 1e3:.9f};{a / G:.8f};{b / G:.8f}" for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(save(folder, ["ms;kN;g;g", "Time;force;a1;a2", *rows]), (record,))


@case("third")
def german_whole_numbers(folder: Path) -> Known:
    """Whole mN with points between thousands, `5.374`, beside decimal commas."""
    record = hit()
    whole_mn = [f"{round(1e3 * f):,d}".replace(",", ".") for f in record.force]
    rows = [
        f"{comma(i / RATE)};{w};{comma(a)};{comma(b)}"
        for i, (w, a, b) in enumerate(zip(whole_mn, record.a1, record.a2, strict=True))
    ]
    return Known(
        save(folder, ["time [s];force [mN];a1 [m/s^2];a2 [m/s^2]", *rows]),
        (record,),
        tolerance=1e-4,
        rejected="(?i)thousands",
    )


@case("third")
def iso_times_and_german_thousands(folder: Path) -> Known:
    """ISO times with a point, numbers with points between thousands and decimal commas."""
    record = hit()
    rows = [
        f"{at(i).isoformat(timespec='microseconds')};" + ";".join(german(1e3 * v) for v in row)
        for i, row in enumerate(record.rows.T)
    ]
    return Known(save(folder, ["time;force [mN];a1 [mm/s^2];a2 [mm/s^2]", *rows]), (record,))


@case("third")
def point_times_and_decimal_commas(folder: Path) -> Known:
    """Times with a point, values with a comma."""
    record = hit()
    rows = [f"{i / RATE:.6f};" + ";".join(comma(v) for v in row) for i, row in enumerate(record.rows.T)]
    return Known(
        save(folder, ["time [s];force [N];a1 [m/s^2];a2 [m/s^2]", *rows]), (record,), rejected="(?i)mark|comma"
    )


@case("third")
def tdms_milliseconds(folder: Path) -> Known:
    """wf_increment 0.5 and wf_xunit_string ms."""
    props = [p | {"wf_increment": 1e3 / RATE, "wf_xunit_string": "ms", "wf_xname": "Time"} for p in waved()]
    return Known(save_tdms(folder, whole(list(hit().rows), props)), (hit(),), rejected="(?i)ms")


@case("third")
def tdms_spectra(folder: Path) -> Known:
    """Amplitudes over frequency: wf_xunit_string Hz."""
    rows = [np.abs(np.fft.rfft(r)) for r in hit().rows]
    props = [p | {"wf_increment": 0.5, "wf_xunit_string": "Hz", "wf_xname": "Frequency"} for p in waved()]
    return Known(save_tdms(folder, whole(rows, props)), rejected="(?i)Hz|frequency")


@case("third")
def lvm_spectra(folder: Path) -> Known:
    """X_Dimension is Frequency."""
    rows = [np.abs(np.fft.rfft(r)) for r in hit().rows]
    lines = [
        line.replace("Time\tTime\tTime", "Frequency\tFrequency\tFrequency") for line in segment(rows, delta=(0.5,) * 3)
    ]
    return Known(save_lvm(folder, head() + lines), rejected="(?i)frequency")


@case("third")
def lvm_milliseconds(folder: Path) -> Known:
    """X_Unit_Label says ms."""
    lines = segment(list(hit().rows), delta=(1e3 / RATE,) * 3)
    place = next(k for k, line in enumerate(lines) if line.startswith("X0"))
    lines.insert(place, "X_Unit_Label\tms\tms\tms")
    return Known(save_lvm(folder, head() + lines), (hit(),), rejected="(?i)ms")


@case("third")
def uff_milliseconds(folder: Path) -> Known:
    """The abscissa's label says ms."""
    right = hit()
    lines = text_58(functions(replace(right, rate=RATE / 1e3)))
    lines = [line.replace(f"{'s':<20s}", f"{'ms':<20s}") if line.startswith("        17") else line for line in lines]
    return Known(save_uff(folder, lines), (right,))


@case("third")
def uff_kilohertz(folder: Path) -> Known:
    """The abscissa's label says kHz."""
    right = KnownFrf(LINES, inertance(LINES)[:, 0])
    parts = frfs(right.values, step=0.0005, first=0.02)
    lines = [
        line.replace(f"{'Hz':<20s}", f"{'kHz':<20s}") if line.startswith("        18") else line
        for line in text_58(parts)
    ]
    return Known(save_uff(folder, units_164(SI) + lines), frf=right, rejected="(?i)kHz")


@case("third")
def uff_over_speed(folder: Path) -> Known:
    """FRFs over a speed in rpm are none over frequency."""
    parts = frfs(inertance(LINES)[:, 0])
    lines = [
        line.replace(f"{'Hz':<20s}", f"{'rpm':<20s}") if line.startswith("        18") else line
        for line in text_58(parts)
    ]
    return Known(save_uff(folder, lines), rejected="(?i)rpm")


@case("third")
def sep_rate_against_times(folder: Path) -> Known:
    """fs says 2000, the times say 1000."""
    series = listed(list(hit().rows))
    for entry in series:
        entry["time"] = (np.arange(1024) / 1000).tolist()
    return Known(save_sep(folder, series), rejected="(?i)fs|rate|1000")


@case("third")
def mat_rate_against_times(folder: Path) -> Known:
    """fs says 2000, t says 1000."""
    parts = dict(zip(("force", "a1", "a2"), hit().rows, strict=True))
    scipy.io.savemat(folder / "case.mat", parts | {"fs": RATE, "t": np.arange(1024) / 1000})
    return Known(("case.mat",), rejected="(?i)1000.*2000|2000.*1000")


@case("third")
def mat_steps(folder: Path) -> Known:
    """dt in place of fs."""
    parts = dict(zip(("force", "a1", "a2"), hit().rows, strict=True))
    scipy.io.savemat(folder / "case.mat", parts | {"dt": 1 / RATE})
    return Known(("case.mat",), (hit(),), rejected="(?i)rate")
