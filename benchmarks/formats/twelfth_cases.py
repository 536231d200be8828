"""A twelfth draw, text: instruments, spreadsheets, clocks, words of other languages, and numbers that say "none"."""

import gzip
from dataclasses import replace
from pathlib import Path

import numpy as np
from damaged_cases import LEFT_OUT, changed
from drawn import Drawn, draws, modes, modes_or_said
from known import VOLTS, G, Known
from lvm_cases import head, number, segment
from lvm_cases import save as save_lvm
from seventh_table_cases import at, cells, rows_of
from tenth_cases import DRIVEN, HEAD
from text_cases import save


@draws("twelfth")
def lvm_rounded_x(folder: Path, d: Drawn) -> Known:
    """X with four digits behind the point, while Delta_X is exact."""
    r = d.hit()
    lines = segment(list(r.rows), "No", delta=(1 / d.rate,) * 3)
    first = next(k for k, line in enumerate(lines) if line.startswith("X_Value")) + 1
    rows = [f"{i / d.rate:.4f}" + line for i, line in enumerate(lines[first:-1])]
    return Known(save_lvm(folder, [*head(), *lines[:first], *rows, ""]), (r,))


@draws("twelfth")
def lvm_with_temperature(folder: Path, d: Drawn) -> Known:
    """UTF-8 with a mark and m/s²; a fourth channel in °C that the rig does not know."""
    r = d.hit()
    rows = [*r.rows, np.linspace(20, 21, d.n)]
    names, units = ("force", "a1", "a2", "T room"), ("N", "m/s²", "m/s²", "°C")
    lines = head() + segment(rows, x0=(0,) * 4, delta=(1 / d.rate,) * 4, units=units, names=names)
    data = "\r\n".join(lines) + "\r\n"
    (folder / "case.lvm").write_text(data, encoding="utf-8-sig", newline="")
    return Known(("case.lvm",), (r,), says="T room")


@draws("twelfth")
def oscilloscope_of_four(folder: Path, d: Drawn) -> Known:
    """Facts of the horizontal and of each channel, labels, TIME,CH1,CH2,CH3; volts of sensors of 10 mV a unit."""
    r = d.hit()
    top = ["Model,MSO44", "Firmware Version,1.30.3", "", "Waveform Type,ANALOG", "Point Format,Y", "Horizontal Units,s"]
    top += ["Horizontal Scale,0.04", f"Sample Interval,{1 / d.rate:.9e}", f"Record Length,{d.n}", "Zero Index,60.0"]
    top += ["Vertical Units,V,V,V", "Probe Attenuation,1.0,1.0,1.0", "Label,Hammer,First,Second", "TIME,CH1,CH2,CH3"]
    rows = rows_of(r, lambda i: f"{(i - 60) / d.rate:.9e}", factors=(0.01, 0.01, 0.01), digits=9)
    said = ("--variable", "force=CH1", "a1=CH2", "a2=CH3")
    return Known(
        save(folder, [*top, *rows], ending="\r\n"), (r,), rig=VOLTS, options=(*DRIVEN, *said), rejected="volts"
    )


@draws("twelfth")
def facts_by_channel_above(folder: Path, d: Drawn) -> Known:
    """Rows of facts a channel: point, name, kind, unit, each with a word in front; tabs."""
    r = d.hit()
    top = ["Exported time traces", "Point id\tHamm:1:+Z\tBeam:1:+Z\tBeam:2:+Z", "Name\tforce\ta1\ta2"]
    top += ["Time\tReal\tReal\tReal", "s\tN\tm/s^2\tm/s^2"]
    said = ("--columns", "time,force:N,a1:m/s^2,a2:m/s^2")
    files = save(folder, [*top, *rows_of(r, between="\t")], name="case.txt")
    return Known(files, (r,), options=(*DRIVEN, *said))


@draws("twelfth")
def units_in_words_below(folder: Path, d: Drawn) -> Known:
    """X,force,a1,a2 and (Second),(N),(g),(g) below; facts above."""
    r = d.hit()
    top = ["Block Name,REC0001", f"Block Size,{d.n}", f"Sampling Rate,{d.rate:.2f} Hz", "", "X,force,a1,a2"]
    rows = rows_of(r, factors=(1, 1 / G, 1 / G), digits=9)
    return Known(save(folder, [*top, "(Second),(N),(g),(g)", *rows]), (r,), rejected="(?i)time")


@draws("twelfth")
def clock_with_colons(folder: Path, d: Drawn) -> Known:
    """Milliseconds behind a third colon, 10:00:00:001, at 1000 Hz."""
    d = replace(d, rate=1000.0, modes=tuple((f * 1000 / d.rate, z, p) for f, z, p in d.modes))
    r = d.hit()

    def clock(i: int) -> str:
        when = at(i, d.rate, "2026-11-28T10:00:59.5")
        return f"{when:%H:%M:%S}:{when.microsecond // 1000:03d}"

    return Known(
        save(folder, [HEAD.replace(" [s]", ""), *rows_of(r, clock)]), (r,), rejected="10:00:59:500", check=modes(d)
    )


@draws("twelfth")
def pandas_timedelta(folder: Path, d: Drawn) -> Known:
    """An index of durations as pandas writes them, `0 days 00:00:00.000488281`, and no name above it."""
    r = d.hit()

    def times(i: int) -> str:
        whole, part = divmod(round(1e9 * i / d.rate), 10**9)
        return f"0 days {whole // 3600:02d}:{whole // 60 % 60:02d}:{whole % 60:02d}.{part:09d}"

    return Known(save(folder, [",force,a1,a2", *rows_of(r, times)]), (r,), rejected="0 days 00:00")


@draws("twelfth")
def nanoseconds_since_1970(folder: Path, d: Drawn) -> Known:
    """Whole nanoseconds of nineteen digits called timestamp, without a unit."""
    r = d.hit()
    rows = rows_of(r, lambda i: str(1795860000 * 10**9 + round(1e9 * i / d.rate)))
    return Known(save(folder, ["timestamp,force,a1,a2", *rows]), (r,), rejected="(?i)timestamp|rate|unit")


@draws("twelfth")
def name_twice(folder: Path, d: Drawn) -> Known:
    """a1 as measured, and a1 once more as filtered: which one it is cannot be known."""
    r = d.hit()
    rows = [f"{row},{v:.7f}" for row, v in zip(rows_of(r), 0.5 * r.a1, strict=True)]
    return Known(save(folder, [HEAD + ",a1 [m/s^2]", *rows]), rejected="(?i)twice|two|a1")


@draws("twelfth")
def estimates_named(folder: Path, d: Drawn) -> Known:
    """H1(a1/force) and H1(a2/force): the 1 is that of the estimate and no point."""
    right = d.frf()
    a, b = right.values
    names = "Frequency (Hz),H1(a1/force) real,H1(a1/force) imag,H1(a2/force) real,H1(a2/force) imag"
    reason = r"(?i)H1\(a1|--columns|--variable"
    return Known(save(folder, [names, *cells(",", right.frequency, a.real, a.imag, b.real, b.imag)]), frf=right,
                 rejected=reason)  # fmt: skip


@draws("twelfth")
def german_words(folder: Path, d: Drawn) -> Known:
    """Frequenz, Betrag, Phase, Kohärenz; decimal commas, g/N."""
    right = d.frf()
    parts = [v for h in right.values / G for v in (abs(h), np.degrees(np.angle(h)), np.full(len(h), 0.999))]
    names = ";".join(["Frequenz [Hz]", *(f"{w} {a} [{u}]" for a in ("a1", "a2")
                     for w, u in (("Betrag", "g/N"), ("Phase", "°"), ("Kohärenz", "-")))])  # fmt: skip
    rows = [row.replace(".", ",") for row in cells(";", right.frequency, *parts)]
    return Known(save(folder, [names, *rows], "cp1252"), frf=right, rejected="(?i)betrag|magnitude")


@draws("twelfth")
def french_words(folder: Path, d: Drawn) -> Known:
    """Fréquence, Module, Phase (°) of two responses; semicolons and decimal commas."""
    right = d.frf()
    parts = [v for h in right.values for v in (abs(h), np.degrees(np.angle(h)))]
    names = "Fréquence (Hz);Module a1 ((m/s²)/N);Phase a1 (°);Module a2 ((m/s²)/N);Phase a2 (°)"
    rows = [row.replace(".", ",") for row in cells(";", right.frequency, *parts)]
    return Known(save(folder, [names, *rows]), frf=right, rejected="(?i)module|magnitude|Fréquence")


@draws("twelfth")
def polar_cells(folder: Path, d: Drawn) -> Known:
    """Complex numbers as magnitude and angle, 0.123∠-45.0°."""
    right = d.frf()
    rows = [
        ",".join([f"{f:.9g}", *(f"{abs(v):.9g}∠{np.degrees(np.angle(v)):.7f}°" for v in both)])
        for f, both in zip(right.frequency, right.values.T, strict=True)
    ]
    return Known(save(folder, ["frequency [Hz],a1 [m/s^2/N],a2 [m/s^2/N]", *rows]), frf=right, rejected="∠")


@draws("twelfth")
def english_thousands(folder: Path, d: Drawn) -> Known:
    """Numbers in mN and mm/s^2 as "1,234.567" in quotes, behind commas."""
    r = d.hit()
    rows = [f"{t:.9f}," + ",".join(f'"{1e3 * v:,.4f}"' for v in row) for t, row in zip(r.time, r.rows.T, strict=True)]
    return Known(save(folder, ["time [s],force [mN],a1 [mm/s^2],a2 [mm/s^2]", *rows]), (r,))


@draws("twelfth")
def newest_first(folder: Path, d: Drawn) -> Known:
    """The newest row on top: times fall."""
    r = d.hit()
    return Known(save(folder, [HEAD, *rows_of(r)[::-1]]), (r,), rejected="(?i)fall|order|descend|decreas|back|rise")


@draws("twelfth")
def two_hits_without_a_break(folder: Path, d: Drawn) -> Known:
    """A second hit below the first, without a header or an empty line: its times begin again."""
    hits = (d.hit(1), d.hit(2))
    rows = [row for r in hits for row in rows_of(r)]
    return Known(save(folder, [HEAD, *rows]), hits, rejected="(?i)time|begin again|back|split")


@draws("twelfth")
def no_value_of_instruments(folder: Path, d: Drawn) -> Known:
    """9.91E+37 in three rows of a2, which IEEE 488.2 instruments write for "not a number"."""
    r = d.hit()
    a2 = r.a2.copy()
    a2[700:703] = 9.91e37
    rows = [",".join([f"{t:.9f}", *(f"{v:.6E}" for v in row)])
            for t, row in zip(r.time, changed(r, a2=a2).rows.T, strict=True)]  # fmt: skip
    said = f"a2.*({700 / d.rate:.3g}|700|701|line 70)"
    return Known(save(folder, [HEAD, *rows]), says=said, rejected=said, check=modes_or_said(d, LEFT_OUT))


@draws("twelfth")
def no_value_of_loggers(folder: Path, d: Drawn) -> Known:
    """-9999 in four rows of a1, which loggers write for a missing value."""
    r = d.hit()
    a1 = r.a1.copy()
    a1[900:904] = -9999.0
    said = f"a1.*({900 / d.rate:.6g}|90[0-5]|line 90)"
    return Known(
        save(folder, [HEAD, *rows_of(changed(r, a1=a1))]), says=said, rejected=said, check=modes_or_said(d, LEFT_OUT)
    )


@draws("twelfth")
def empty_warm_up(folder: Path, d: Drawn) -> Known:
    """The responses' first twelve cells are empty, as a filter that has not settled leaves them."""
    r = d.hit()
    rows = [row if i >= 12 else ",".join([*row.split(",")[:2], "", ""]) for i, row in enumerate(rows_of(r))]
    return Known(save(folder, [HEAD, *rows]), (r.part(12),), rejected="(?i)line [2-9]|empty|missing", check=modes(d))


@draws("twelfth")
def table_compressed(folder: Path, d: Drawn) -> Known:
    """A table as pandas compresses it: case.csv.gz."""
    r = d.hit()
    (folder / "case.csv.gz").write_bytes(gzip.compress("\n".join([HEAD, *rows_of(r), ""]).encode()))
    return Known(("case.csv.gz",), (r,), rejected="(?i)gzip|compress|unpack")


@draws("twelfth")
def lvm_no_decimal_tag(folder: Path, d: Drawn) -> Known:
    """Decimal commas that no tag names, a channel's own X in seconds since 1904 with a fraction, two segments."""
    hits = (d.hit(1), d.hit(2))
    lines = [
        line for line in head(columns="Multi", decimal=",", multi="Yes") if not line.startswith("Decimal_Separator")
    ]
    for k, r in enumerate(hits):
        lines += segment(list(r.rows), "Multi", decimal=",", x0=(12.5 * k,) * 3, delta=(1 / d.rate,) * 3)
    assert number(1.5, ",") == "1,5000000E+00"
    return Known(save_lvm(folder, lines), hits)
