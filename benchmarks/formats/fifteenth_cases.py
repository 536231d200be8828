"""A fifteenth draw, text, drawn with the fourteenth: oscilloscopes, analysers, spreadsheets, words of languages."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from drawn import Drawn, draws
from known import DISPLACEMENT, PLAIN, G, Known, KnownFrf
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from seventh_table_cases import INCH, LBF, cells, rows_of
from tenth_cases import DRIVEN
from text_cases import save


@draws("fifteenth")
def lecroy_three_files(folder: Path, d: Drawn) -> Known:
    """LeCroy: a file for each channel, with Segments, TrigTime and `Time,Ampl` above."""
    r = d.hit()
    files = []
    for k, row in enumerate(r.rows, 1):
        top = ["LECROYWS104Xs,12345,Waveform", f"Segments,1,SegmentSize,{d.n}", "Segment,TrigTime,TimeSinceSegment1"]
        top += ["#1,26-Nov-2026 10:00:00,0", "Time,Ampl"]
        rows = [f"{t:.9f},{v:.7f}" for t, v in zip(r.time, row, strict=True)]
        files += save(folder, [*top, *rows], ending="\r\n", name=f"C{k}Trace00000.csv")
    return Known(tuple(files), (r,), rejected="(?i)Ampl|force|channel")


@draws("fifteenth")
def ono_sokki_lines(folder: Path, d: Drawn) -> Known:
    """An FFT analyser: fifteen lines of facts with commas, then lines, real and imaginary parts of two traces."""
    right = d.frf()
    a, b = right.values
    top = [
        "CF-9200,Ver.1.4",
        "Date,2026/11/26",
        "Time,10:00:00",
        f"Lines,{len(right.frequency)}",
        "Frequency Range,200",
    ]
    top += ["Window,Rect.", "Average,5,Power Sum", "Label,,", "Memo,,", "Data,FRF,FRF", "Channel,Ch2/Ch1,Ch3/Ch1"]
    top += ["X Unit,Hz,Hz", "Y Unit,(m/s2)/N,(m/s2)/N", "Scale,Lin,Lin", "Hz,Real,Imag,Real,Imag"]
    rows = cells(",", right.frequency, a.real, a.imag, b.real, b.imag)
    return Known(save(folder, [*top, *rows], "shift_jis", "\r\n"), frf=right, rejected="--columns")


@draws("fifteenth")
def times_and_spectrum(folder: Path, d: Drawn) -> Known:
    """Times with force and accelerations, and beside them a shorter table of an FRF over its own frequencies."""
    r, right = d.hit(), d.frf()
    h = right.values[0]
    rows = [f"{t:.9f}\t{f:.7f}\t{a:.7f}\t{b:.7f}\t"
            + (f"{right.frequency[i]:.4f}\t{h[i].imag:.9g}" if i < len(h) else "\t")
            for i, (t, (f, a, b)) in enumerate(zip(r.time, r.rows.T, strict=True))]  # fmt: skip
    top = ["Impact", "26.11.2026", "Zeit [s]\tforce [N]\ta1 [m/s²]\ta2 [m/s²]\tFrequenz [Hz]\tImag [(m/s²)/N]"]
    files = save(folder, [row.replace(".", ",") for row in [*top, *rows]], "cp1252", "\r\n", name="case.txt")
    return Known(files, (r,), rejected="(?i)Frequenz|--columns|time and frequency|both")


@draws("fifteenth")
def matlab_ascii(folder: Path, d: Drawn) -> Known:
    """MATLAB's save -ascii: columns of width with eight digits, no header; columns said."""
    d = replace(d, rate=2048.0)
    r = d.hit()
    rows = ["".join(f"{v:16.7e}" for v in row) for row in np.vstack([r.time, r.rows]).T]
    said = ("--columns", "time,force:N,a1:m/s^2,a2:m/s^2")
    return Known(save(folder, rows, name="case.txt"), (r,), options=(*DRIVEN, *said))


@draws("fifteenth")
def italian_words(folder: Path, d: Drawn) -> Known:
    """Frequenza, Parte reale, Parte immaginaria of two responses; semicolons and decimal commas."""
    right = d.frf()
    a, b = right.values
    top = [
        "Frequenza [Hz]",
        *(f"{part} {n} [(m/s²)/N]" for n in ("a1", "a2") for part in ("Parte reale", "Parte imm.")),
    ]
    rows = cells(";", right.frequency, a.real, a.imag, b.real, b.imag)
    files = save(folder, [";".join(top), *(row.replace(".", ",") for row in rows)])
    return Known(files, frf=right, rejected="(?i)--columns|Parte")


@draws("fifteenth")
def japanese_words(folder: Path, d: Drawn) -> Known:
    """Names and facts in Shift JIS; the names are said."""
    r = d.hit()
    top = [
        "測定日時,2026/11/26 10:00:00",
        "サンプリング周波数," + f"{d.rate:g}" + ",Hz",
        "時間,力,加速度1,加速度2",
        "s,N,m/s2,m/s2",
    ]
    said = ("--variable", "force=力", "a1=加速度1", "a2=加速度2", "time=時間")
    files = save(folder, [*top, *rows_of(r)], "shift_jis", "\r\n")
    return Known(files, (r,), options=(*DRIVEN, *said), rejected="(?i)encod|力|--columns|--variable")


@draws("fifteenth")
def decibels_of_pounds(folder: Path, d: Drawn) -> Known:
    """Levels in dB re 1 g/lbf and phases in degrees."""
    right = d.frf()
    levels = 20 * np.log10(abs(right.values) * LBF / G)
    a, b = np.angle(right.values, deg=True)
    top = "Frequency (Hz),a1 Level (dB re 1 g/lbf),a1 Phase (deg),a2 Level (dB re 1 g/lbf),a2 Phase (deg)"
    return Known(save(folder, [top, *cells(",", right.frequency, levels[0], a, levels[1], b)]), frf=right)


@draws("fifteenth")
def rounded_before_trigger(folder: Path, d: Drawn) -> Known:
    """Times from -0.0200 s with four decimals, `Sample Rate (Hz):` above."""
    d = replace(d, rate=2048.0)
    r = d.hit()
    rows = rows_of(r, lambda i: f"{i / d.rate - 0.02:.4f}")
    return Known(
        save(folder, [f"Sample Rate (Hz):,{d.rate:g},,", "", "Time (s),force (N),a1 (m/s2),a2 (m/s2)", *rows]), (r,)
    )


@draws("fifteenth")
def milliseconds_that_are_seconds(folder: Path, d: Drawn) -> Known:
    """`Time [ms]` above times in s, and a sample rate above both: one of them is wrong."""
    r = d.hit()
    top = [f"Sample rate [Hz],{d.rate:g},,", "Time [ms],force [N],a1 [m/s^2],a2 [m/s^2]"]
    return Known(save(folder, [*top, *rows_of(r)]), rejected="(?i)rate")


@draws("fifteenth")
def receptance_in_inches(folder: Path, d: Drawn) -> Known:
    """Compliances in in/lbf, real and imaginary, `H11` and `H21`."""
    right = d.frf("receptance")
    a, b = right.values * LBF / INCH
    top = "Freq (Hz),Re H11 (in/lbf),Im H11 (in/lbf),Re H21 (in/lbf),Im H21 (in/lbf)"
    rows = [
        ",".join(f"{v:.9e}" for v in row) for row in zip(right.frequency, a.real, a.imag, b.real, b.imag, strict=True)
    ]
    return Known(save(folder, [top, *rows]), frf=right, rig=DISPLACEMENT)


@draws("fifteenth")
def a_file_a_channel(folder: Path, d: Drawn) -> Known:
    """force.csv, a1.csv and a2.csv, each time and value."""
    r = d.hit()
    files = []
    for name, unit, row in zip(("force", "a1", "a2"), ("N", "m/s^2", "m/s^2"), r.rows, strict=True):
        rows = [f"{t:.9f},{v:.7f}" for t, v in zip(r.time, row, strict=True)]
        files += save(folder, [f"time [s],{name} [{unit}]", *rows], name=f"{name}.csv")
    return Known(tuple(files), (r,), rejected="(?i)a1|channel|force")


@draws("fifteenth")
def parts_in_two_files(folder: Path, d: Drawn) -> Known:
    """The real parts in one file, the imaginary parts in another, with the same headings."""
    right = d.frf()
    files = []
    for name, part in (("real.csv", right.values.real), ("imag.csv", right.values.imag)):
        top = "frequency [Hz],a1 [m/s^2/N],a2 [m/s^2/N]"
        files += save(folder, [top, *cells(",", right.frequency, *part)], name=name)
    return Known(tuple(files), rejected="(?i)complex|imag|phase|real|time")


@draws("fifteenth")
def lvm_units_in_names(folder: Path, d: Drawn) -> Known:
    """No Y_Unit_Label; names `force (kN)`, `a1 (g)`, `a2 (g)`; time relative."""
    r = d.hit()
    rows = [r.force / 1e3, r.a1 / G, r.a2 / G]
    lines = segment(rows, delta=(1 / d.rate,) * 3, names=("force (kN)", "a1 (g)", "a2 (g)"))
    lines = [line for line in lines if not line.startswith("Y_Unit_Label")]
    return Known(save_lvm(folder, [*(line.replace("Absolute", "Relative") for line in head()), *lines]), (r,))


@draws("fifteenth")
def origin_rows(folder: Path, d: Drawn) -> Known:
    """Origin: long names, units, comments and designations in rows of their own; tabs."""
    r = d.hit()
    top = [
        "Time\tforce\ta1\ta2",
        "s\tN\tm/s\u2072\tm/s\u2072".replace("\u2072", "²"),
        "\thammer\tleft end\tright end",
        "X\tY\tY\tY",
    ]
    return Known(save(folder, [*top, *rows_of(r, between="\t")], name="case.txt"), (r,))


@draws("fifteenth")
def gravities_by_word(folder: Path, d: Drawn) -> Known:
    """`Accel 1 (g's)` and a force in `lbs`; what pounds these are is said by --columns."""
    r = d.hit()
    rows = rows_of(r, factors=(1 / LBF, 1 / G, 1 / G), digits=9)
    top = "Elapsed Time (sec),Hammer (lbs),Accel 1 (g's),Accel 2 (g's)"
    said = ("--columns", "time,force:lbf,a1:g,a2:g")
    return Known(save(folder, [top, *rows]), (r,), options=(*DRIVEN, *said))


@draws("fifteenth")
def counts_without_scale(folder: Path, d: Drawn) -> Known:
    """A converter's counts, `force [counts]`: without a scale they are no forces."""
    r = d.hit()
    rows = [f"{t:.9f}," + ",".join(f"{100 * v:.0f}" for v in row) for t, row in zip(r.time, r.rows.T, strict=True)]
    return Known(save(folder, ["time [s],force [counts],a1 [counts],a2 [counts]", *rows]), rejected="(?i)counts")


@draws("fifteenth")
def inverted_decibels(folder: Path, d: Drawn) -> Known:
    """Magnitudes in dB without a phase: no FRF is to be had."""
    right = d.frf()
    rows = cells(",", right.frequency, *(20 * np.log10(abs(right.values))))
    return Known(save(folder, ["Frequency [Hz],a1 [dB],a2 [dB]", *rows]), rejected="(?i)phase|complex|dB")


@draws("fifteenth")
def nyquist_and_bode(folder: Path, d: Drawn) -> Known:
    """Real, imaginary, magnitude and phase of the same FRF beside each other."""
    right = d.frf()
    h = right.values[1]
    rig = PLAIN.replace("- {index: 1, name: a1, quantity: acceleration, unit: m/s^2, point: 1}\n", "")
    top = "Frequency (Hz),Real (m/s^2/N),Imag (m/s^2/N),Magnitude (m/s^2/N),Phase (deg)"
    rows = cells(",", right.frequency, h.real, h.imag, abs(h), np.angle(h, deg=True))
    known = KnownFrf(right.frequency, h[None])
    files = save(folder, [top, *rows])
    return Known(files, frf=known, rig=rig.replace("index: 2", "index: 1"), rejected="(?i)twice|both|magnitude|columns",
                 check=lambda folder: "")  # fmt: skip
