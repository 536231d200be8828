"""A fourteenth draw, text, after what instruments, telephones, languages of statistics and students write."""

import json
from pathlib import Path

import numpy as np
from drawn import Drawn, draws
from known import PLAIN, VELOCITY, Known, KnownFrf
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from seventh_table_cases import cells, rows_of
from tenth_cases import DRIVEN
from text_cases import save

VOLTS = PLAIN.replace(", point", ", sensitivity_v_per_unit: 0.01, point")


@draws("fourteenth")
def digilent(folder: Path, d: Drawn) -> Known:
    """WaveForms: facts behind #, `Time (s),Channel 1 (V)`, times from before the trigger on."""
    r = d.hit()
    top = ["#Digilent WaveForms Oscilloscope Acquisition", "#Device Name: Discovery2", "#Serial Number: SN:210321A0000"]
    top += ["#Date Time: 2026-11-26 10:00:00.000", f"#Sample rate: {d.rate:g}Hz", f"#Samples: {d.n}"]
    top += ["#Trigger: Source: Channel 1 Type: Edge Condition: Rise Level: 1 V"]
    top += ["#Channel 1: Range: 500 mV/div Offset: -1 V", "", "Time (s),Channel 1 (V),Channel 2 (V),Channel 3 (V)"]
    rows = rows_of(r, lambda i: f"{(i - 40) / d.rate:.9g}", factors=(0.01,) * 3, digits=9)
    said = ("--variable", "force=Channel 1", "a1=Channel 2", "a2=Channel 3")
    return Known(save(folder, [*top, *rows]), (r,), options=(*DRIVEN, *said), rig=VOLTS)


@draws("fourteenth")
def signal_calc_pairs(folder: Path, d: Drawn) -> Known:
    """SignalCalc: three signals in a group, a coherence among them; `H1, 2` above `Real`, EU, and the units below."""
    right = d.frf()
    a, b = right.values
    unit = "(m/s²)/N"
    top = ["Data written for 2 signals in a group signal", "Ref Chan:Resp Chan\t 1Z:1Z\t 1Z:1Z\t 1Z:2Z\t 1Z:2Z"]
    top += ["Channel Names\tforce:a1\tforce:a1\tforce:a2\tforce:a2", "Channel Comments\t\t\t\t", ""]
    top += ["   \t H1, 2\t H1, 2\t H1, 3\t H1, 3", "Frequency\t Real\t Imag\t Real\t Imag", "   \tEU\tEU\tEU\tEU", ""]
    top += ["Units:", "\t".join(["Hz", *4 * [unit]])]
    rows = cells("\t", right.frequency, a.real, a.imag, b.real, b.imag)
    return Known(save(folder, [*top, *rows], "cp1252", "\r\n", name="case.txt"), frf=right, rejected="(?i)--columns")


@draws("fourteenth")
def sensor_logger(folder: Path, d: Drawn) -> Known:
    """A telephone: `time` in whole nanoseconds since 1970 and beside it `seconds_elapsed`."""
    r = d.hit()
    start = 1700000000 * 10**9
    rows = rows_of(r, lambda i: f"{start + round(1e9 * i / d.rate)},{0.07 + i / d.rate:.9f}")
    return Known(save(folder, ["time,seconds_elapsed,force,a1,a2", *rows]), (r,))


@draws("fourteenth")
def hantek(folder: Path, d: Drawn) -> Known:
    """nr,time,ch1,ch2,ch3 and the same in counts of the screen; volts of sensors."""
    r = d.hit()
    rows = [
        ",".join([str(i), f"{i / d.rate:.9g}", *(f"{v / 100:.9g}" for v in row), *(f"{v:.0f}" for v in row)])
        for i, row in enumerate(r.rows.T)
    ]
    said = ("--variable", "force=ch1", "a1=ch2", "a2=ch3", "--volts")
    return Known(save(folder, ["nr,time,ch1,ch2,ch3,ch1s,ch2s,ch3s", *rows]), (r,), options=(*DRIVEN, *said), rig=VOLTS)


@draws("fourteenth")
def vibsoft(folder: Path, d: Drawn) -> Known:
    """A single vibrometer's text: facts with colons and tabs, names, and units in spaced brackets; velocities."""
    r = d.hit(derivatives=1)
    top = ["Source File Name:\thit_01.pvd", "Point Index:\t1", "Component:\tRoot Point", "Signal:\tVelocity", ""]
    top += ["Time\tRef1\tVibrometer\tVib Y", "[ s ]\t[ N ]\t[ m/s ]\t[ mm/s ]"]
    rows = [f"{t:.9e}\t{f:.7e}\t{a:.9e}\t{1e3 * b:.9e}" for t, (f, a, b) in zip(r.time, r.rows.T, strict=True)]
    said = ("--variable", "force=Ref1", "a1=Vibrometer", "a2=Vib Y")
    files = save(folder, [*top, *rows], ending="\r\n", name="case.txt")
    return Known(files, (r,), options=(*DRIVEN, *said), rig=VELOCITY)


@draws("fourteenth")
def r_write_table(folder: Path, d: Drawn) -> Known:
    """write.table of R: names in quotes, rows begin with their quoted number, which the header has no name for."""
    r = d.hit()
    rows = [f'"{i}" {row}' for i, row in enumerate(rows_of(r, between=" "), 1)]
    return Known(save(folder, ['"time" "force" "a1" "a2"', *rows], name="case.txt"), (r,))


@draws("fourteenth")
def octave_variables(folder: Path, d: Drawn) -> Known:
    """Octave's save -text: `# name: t`, `# type: matrix`, `# rows:`, `# columns:`, and one column below."""
    r = d.hit()
    lines = ["# Created by Octave 8.4.0, Thu Nov 26 10:00:00 2026 UTC <user@host>"]
    for name, row in zip(("time", "force", "a1", "a2"), (r.time, *r.rows), strict=True):
        lines += [f"# name: {name}", "# type: matrix", f"# rows: {d.n}", "# columns: 1"]
        lines += [*(f" {v:.9g}" for v in row), "", ""]
    return Known(save(folder, lines, name="case.txt"), (r,), rejected="(?i)octave|one column|below")


@draws("fourteenth")
def spanish_words(folder: Path, d: Drawn) -> Known:
    """Frecuencia, Módulo, Fase (°), Coherencia of one response; semicolons, decimal commas."""
    right = d.frf()
    h = right.values[1]
    rig = PLAIN.replace("- {index: 1, name: a1, quantity: acceleration, unit: m/s^2, point: 1}\n", "")
    top = "Frecuencia (Hz);Módulo ((m/s²)/N);Fase (°);Coherencia"
    rows = cells(";", right.frequency, abs(h), np.angle(h, deg=True), np.full(len(h), 0.999))
    known = KnownFrf(right.frequency, h[None], coherence=np.full((1, len(h)), 0.999))
    files = save(folder, [top, *(row.replace(".", ",") for row in rows)], "utf-8-sig", "\r\n")
    return Known(files, frf=known, rig=rig.replace("index: 2", "index: 1"), check=lambda folder: "")


@draws("fourteenth")
def magnitudes_then_phases(folder: Path, d: Drawn) -> Known:
    """All magnitudes, then all phases: f [Hz], |H11|, |H21|, ∠H11 [rad], ∠H21 [rad]."""
    right = d.frf()
    a, b = right.values
    top = "f [Hz],|H11| [m/s^2/N],|H21| [m/s^2/N],∠H11 [rad],∠H21 [rad]"
    rows = cells(",", right.frequency, abs(a), abs(b), np.angle(a), np.angle(b))
    return Known(save(folder, [top, *rows]), frf=right, rejected="∠")


@draws("fourteenth")
def undefined_at_zero(folder: Path, d: Drawn) -> Known:
    """The line at 0 Hz is there, and its numbers are NaN, as a division by zero leaves them."""
    right = d.frf()
    a, b = right.values
    rows = cells(",", right.frequency, a.real, a.imag, b.real, b.imag)
    top = "frequency [Hz],Re(a1) [m/s^2/N],Im(a1) [m/s^2/N],Re(a2) [m/s^2/N],Im(a2) [m/s^2/N]"
    return Known(save(folder, [top, "0,NaN,NaN,NaN,NaN", *rows]), frf=right, rejected="(?i)nan|0 Hz|not a number")


@draws("fourteenth")
def time_last(folder: Path, d: Drawn) -> Known:
    """Time is the last column, in ms."""
    r = d.hit()
    rows = [",".join([*(f"{v:.7f}" for v in row), f"{1e3 * t:.7f}"]) for t, row in zip(r.time, r.rows.T, strict=True)]
    return Known(save(folder, ["force [N],a1 [m/s^2],a2 [m/s^2],Time [ms]", *rows]), (r,))


@draws("fourteenth")
def decanewtons(folder: Path, d: Drawn) -> Known:
    """Temps (s), Force (daN), and accelerations in m.s-2; decimal commas."""
    r = d.hit()
    rows = [row.replace(".", ",") for row in rows_of(r, between=";", factors=(0.1, 1, 1), digits=9)]
    said = ("--variable", "force=Force")
    files = save(folder, ["Temps (s);Force (daN);a1 (m.s-2);a2 (m.s-2)", *rows], "cp1252", "\r\n")
    return Known(files, (r,), options=(*DRIVEN, *said))


@draws("fourteenth")
def hits_side_by_side(folder: Path, d: Drawn) -> Known:
    """Two hits beside each other: time, force_1, a1_1, a2_1, force_2, a1_2, a2_2."""
    one, two = d.hit(1), d.hit(2)
    names = ["time", *(f"{n}_{k}" for k in (1, 2) for n in ("force", "a1", "a2"))]
    rows = cells(",", one.time, *one.rows, *two.rows)
    return Known(save(folder, [",".join(names), *rows]), (one, two), rejected="(?i)force_1|--variable|--columns|a1_1")


@draws("fourteenth")
def json_lines(folder: Path, d: Drawn) -> Known:
    """One JSON object a line, as loggers that stream write."""
    r = d.hit()
    lines = [json.dumps({"t": round(t, 9), "force": f, "a1": a, "a2": b})
             for t, (f, a, b) in zip(r.time.tolist(), r.rows.T.tolist(), strict=True)]  # fmt: skip
    return Known(save(folder, lines, name="case.jsonl"), (r,), rejected="(?i)json|jsonl|line 1")


@draws("fourteenth")
def diadem_dat(folder: Path, d: Drawn) -> Known:
    """DIAdem's header DIAEXTENDED, whose numbers stand in a binary file beside it."""
    r = d.hit()
    (folder / "case.R64").write_bytes(r.rows.tobytes())
    lines = ["DIAEXTENDED  {@:ENGLISH", "", "#BEGINGLOBALHEADER", "  1,WINDOWS 32Bit", "104,26.11.2026"]
    lines += ["105,10:00:00", "112,High -> Low", "#ENDGLOBALHEADER", ""]
    for k, (name, unit) in enumerate((("force", "N"), ("a1", "m/s²"), ("a2", "m/s²"))):
        lines += ["#BEGINCHANNELHEADER", f"200,{name}", f"202,{unit}", "210,EXPLICIT", "211,case.R64", "213,BLOCK"]
        lines += ["214,REAL64", f"220,{d.n}", f"221,{1 + k * d.n}", "#ENDCHANNELHEADER", ""]
    files = save(folder, lines, "cp1252", "\r\n", name="case.dat")
    return Known(files, rejected="(?i)diadem|DIAEXTENDED|other file|R64|no table|known")


@draws("fourteenth")
def lvm_frf(folder: Path, d: Drawn) -> Known:
    """LabVIEW's FRF: magnitude and phase, X_Dimension Frequency, Delta_X 0.25."""
    right = d.frf(lines=np.arange(1, 801) * 0.25)
    h = right.values[0]
    names = ("FRF (Magnitude)", "FRF (Phase)")
    lines = segment([abs(h), np.angle(h, deg=True)], x0=(0.25,) * 2, delta=(0.25,) * 2,
                    units=("m/s^2/N", "deg"), names=names)  # fmt: skip
    lines = [line.replace("X_Dimension\tTime\tTime", "X_Dimension\tFrequency\tFrequency") for line in lines]
    return Known(save_lvm(folder, [*head(), *lines]), rejected="(?i)frequenc|FRF|spectr")


@draws("fourteenth")
def igor_text(folder: Path, d: Drawn) -> Known:
    """Igor: IGOR, WAVES/D and names, BEGIN, rows, END, and the step in `X SetScale/P x`."""
    r = d.hit()
    rows = ["\t" + "\t".join(f"{v:.9g}" for v in row) for row in r.rows.T]
    below = [f'X SetScale/P x 0,{1 / d.rate:.12g},"s", {n}; SetScale y 0,0,"{u}", {n}'
             for n, u in (("force", "N"), ("a1", "m/s^2"), ("a2", "m/s^2"))]  # fmt: skip
    files = save(
        folder, ["IGOR", "WAVES/D\tforce\ta1\ta2", "BEGIN", *rows, "END", *below], ending="\r", name="case.itx"
    )
    return Known(files, (r,), rejected="(?i)igor|--rate|--columns|WAVES")


@draws("fourteenth")
def serial_header(folder: Path, d: Drawn) -> Known:
    """Rows of a serial port, whose names stand behind `#h:`; no times, the rate is said."""
    r = d.hit()
    rows = [",".join(f"{v:.7f}" for v in row) for row in r.rows.T]
    files = save(folder, ["#h:force,a1,a2", *rows], ending="\r\n")
    return Known(files, (r,), options=(*DRIVEN, "--rate", f"{d.rate!r}"), rejected="(?i)#h:|--columns|header")
