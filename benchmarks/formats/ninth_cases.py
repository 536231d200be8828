"""A ninth draw, text: tables of loggers, recorders and oscilloscopes, clocks, and FRFs in units of their own."""

from pathlib import Path

import numpy as np
from drawn import Drawn, draws, modes
from known import PLAIN, VELOCITY, G, Known
from seventh_table_cases import at, cells, rows_of, slow
from text_cases import save

DRIVEN = ("--drive-point", "1")
VOLTS = PLAIN.replace(", point", ", sensitivity_v_per_unit: 0.01, point")
HUNDREDTHS = (0.01, 0.01, 0.01)


@draws("ninth")
def campbell_toa5(folder: Path, d: Drawn) -> Known:
    """A logger's TOA5: its station, names, units with TS and RN, kinds of processing, then rows; all texts quoted."""
    d = slow(d)
    r = d.hit()
    head = ['"TOA5","bridge","CR6","1234","CR6.Std.10","CPU:a.CR6","57111","fast"']
    head += ['"TIMESTAMP","RECORD","force","a1","a2"', '"TS","RN","N","m/s^2","m/s^2"', '"","","Smp","Smp","Smp"']

    def times(i: int) -> str:
        return f'"{at(i, d.rate, "2026-11-28T10:00:00"):%Y-%m-%d %H:%M:%S.%f}",{i}'

    return Known(save(folder, [*head, *rows_of(r, times)], ending="\r\n", name="case.dat"), (r,))


@draws("ninth")
def rohde_schwarz(folder: Path, d: Drawn) -> Known:
    """An oscilloscope's header `in s,C1 in V,C2 in V,C3 in V`, times that begin before the trigger."""
    r = d.hit()
    rows = rows_of(r, lambda i: f"{(i - 100) / d.rate:.9E}", factors=HUNDREDTHS, digits=9)
    said = ("--variable", "force=C1", "a1=C2", "a2=C3")
    files = save(folder, ["in s,C1 in V,C2 in V,C3 in V", *rows])
    return Known(files, (r,), rig=VOLTS, options=(*DRIVEN, *said), rejected="(?i)--columns")


@draws("ninth")
def graphtec(folder: Path, d: Drawn) -> Known:
    """Facts, a table of amplifier settings, Data, then Number, Date&Time, ms, CH1..CH3, Alarm, signs and blanks."""
    d = Drawn(d.modes, 1000.0 * round(d.rate / 1000), d.n, d.seed)
    r = d.hit()
    head = ["Vendor       ,GRAPHTEC Corporation", "Model        ,GL980", "Sampling interval ,1ms", "Amp settings"]
    head += ["CH,Signal name,Input ,Range ,Filter ,Span"]
    head += [f'CH{k} ,"{n}" ,DC   ,5V    ,Off,-5.0 ,5.0,V' for k, n in enumerate(("force", "a1", "a2"), 1)]
    head += ["Data", "Number,Date&Time,ms,CH1,CH2,CH3,Alarm", "NO.,Time,ms,V,V,V,A1234567890"]
    rows = [
        f"{i + 1},{at(i, d.rate, '2026-11-28T10:00:00'):%Y-%m-%d %H:%M:%S},{i / d.rate * 1e3 % 1000:.3f},"
        + ",".join(f"{v:+.7f}" for v in 0.01 * row) + ",LLLLLLLLLL"
        for i, row in enumerate(r.rows.T)
    ]  # fmt: skip
    said = ("--variable", "force=CH1", "a1=CH2", "a2=CH3")
    files = save(folder, [*head, *rows])
    reason = "(?i)coarse|digit|ascend|--columns|twice"
    return Known(files, (r,), rig=VOLTS, options=(*DRIVEN, *said), rejected=reason, tolerance=1e-4)


@draws("ninth")
def hioki(folder: Path, d: Drawn) -> Known:
    """A memory recorder: quoted facts with a date 'YY-MM-DD, then "Time","force[kN]","a1[G]","a2[G]" and exponents."""
    r = d.hit()
    head = ['"HIOKI 8847 V4.00"', '"COMMENT",""', '"TRIGGER TIME","\'26-11-28","10:00:00"']
    head += [f'"NUMBER",{d.n}', '"INTERVAL",' + f"{1 / d.rate:.5E}", '"Time","force[kN]","a1[G]","a2[G]"']
    rows = rows_of(r, lambda i: f"{i / d.rate:.8E}", factors=(1e-3, 1 / G, 1 / G), digits=10)
    return Known(save(folder, [*head, *rows], ending="\r\n"), (r,))


@draws("ninth")
def dasylab(folder: Path, d: Drawn) -> Known:
    """Facts with `Delta: x sec.`, Date;Measurement time[hh:mm:ss], units in brackets, decimal commas, `;` at ends."""
    d = slow(d)
    r = d.hit()
    head = ["DASYLab - V 13.00.00", "Worksheet name: a case", "Recording date: 11/28/2026,  10:00:00 AM"]
    head += ["Block length : 1024", f"Delta: {1 / d.rate:.6f} sec.", "Number of channels : 3"]
    head += ["Date;Measurement time[hh:mm:ss];force [N];a1 [m/s²];a2 [m/s²];"]
    rows = [
        f"11/28/2026;{at(i, d.rate, '2026-11-28T10:00:00'):%H:%M:%S.%f};".replace(".", ",")
        + ";".join(f"{v:.7f}".replace(".", ",") for v in row) + ";"
        for i, row in enumerate(r.rows.T)
    ]  # fmt: skip
    return Known(save(folder, [*head, *rows], "cp1252", "\r\n", "case.asc"), (r,))


@draws("ninth")
def spoken_units(folder: Path, d: Drawn) -> Known:
    """The same unit as `m/sec^2` and as `m/s/s`, times in `sec`, the force in `Newton`."""
    r = d.hit()
    return Known(save(folder, ["Time (sec),force (Newton),a1 (m/sec^2),a2 (m/s/s)", *rows_of(r)]), (r,))


@draws("ninth")
def new_year_of_two_digits(folder: Path, d: Drawn) -> Known:
    """31.12.26 23:59:59,9 to 01.01.27 00:00:00,0: years of two digits."""
    d = slow(d)
    r = d.hit()

    def times(i: int) -> str:
        return f"{at(i, d.rate, '2026-12-31T23:59:59.9'):%d.%m.%y %H:%M:%S.%f}".replace(":59.", ":59,")

    rows = [row.replace(".", ",") for row in rows_of(r, lambda i: "", ";")]
    whole = [times(i)[:-7] + "," + times(i)[-6:] + row for i, row in enumerate(rows)]
    files = save(folder, ["Zeit;force [N];a1 [m/s²];a2 [m/s²]", *whole])
    return Known(files, (r,), tolerance=1e-4)


@draws("ninth")
def irig_days_of_the_year(folder: Path, d: Drawn) -> Known:
    """IRIG time, `332:23:59:59.900000` to `333:00:00:00.000000`."""
    d = slow(d)
    r = d.hit()
    rows = rows_of(r, lambda i: f"{at(i, d.rate, '2026-11-28T23:59:59.9'):%j:%H:%M:%S.%f}")
    files = save(folder, ["IRIG,force [N],a1 [m/s^2],a2 [m/s^2]", *rows])
    return Known(files, (r,), tolerance=1e-4, rejected=r"332:23:59:59\.9")


@draws("ninth")
def frf_per_kilogram(folder: Path, d: Drawn) -> Known:
    """Inertances in 1/kg, which is (m/s^2)/N, real and imaginary parts."""
    right = d.frf()
    a, b = right.values
    head = "Frequency [Hz],a1 Re [1/kg],a1 Im [1/kg],a2 Re [1/kg],a2 Im [1/kg]"
    return Known(save(folder, [head, *cells(",", right.frequency, a.real, a.imag, b.real, b.imag)]), frf=right,
                 check=modes(d))  # fmt: skip


@draws("ninth")
def frf_seconds_per_kilogram(folder: Path, d: Drawn) -> Known:
    """Mobilities in s/kg, magnitude and degrees, of velocity channels."""
    right = d.frf("mobility")
    parts = [v for h in right.values for v in (abs(h), np.degrees(np.angle(h)))]
    head = "f [Hz];|a1| [s/kg];arg a1 [°];|a2| [s/kg];arg a2 [°]"
    return Known(save(folder, [head, *cells(";", right.frequency, *parts)]), frf=right, rig=VELOCITY,
                 rejected="(?i)arg|--columns")  # fmt: skip


@draws("ninth")
def frf_with_force_spectrum(folder: Path, d: Drawn) -> Known:
    """The force's spectrum in N²/Hz beside the FRFs: left out, with a note."""
    right = d.frf()
    a, b = right.values
    head = "Frequency (Hz),PSD force (N^2/Hz),a1 real (m/s²/N),a1 imag (m/s²/N),a2 real (m/s²/N),a2 imag (m/s²/N)"
    rows = cells(",", right.frequency, 1e-3 + 0 * right.frequency, a.real, a.imag, b.real, b.imag)
    return Known(save(folder, [head, *rows]), frf=right, says="PSD", rejected="PSD")


@draws("ninth")
def auto_and_cross_spectra(folder: Path, d: Drawn) -> Known:
    """Gff, and real and imaginary parts of Gfa1 and Gfa2 in spectra's units: no FRFs."""
    a, b = d.frf().values
    parts = ("Gfa1 real", "Gfa1 imag", "Gfa2 real", "Gfa2 imag")
    head = "Frequency (Hz),Gff (N²/Hz)," + ",".join(f"{part} (N m/s²/Hz)" for part in parts)
    rows = cells(",", d.lines, 0.1 + 0 * d.lines, 0.1 * a.real, 0.1 * a.imag, 0.1 * b.real, 0.1 * b.imag)
    return Known(save(folder, [head, *rows]), rejected="(?i)G[fa]{2}|N.?m/s|/Hz|spectr")


@draws("ninth")
def frf_gamma_squared(folder: Path, d: Drawn) -> Known:
    """Coherences named γ²(a1), between the parts of the FRFs, decimal commas."""
    right = d.frf()
    one = 0.9999 + 0 * right.frequency
    parts = [v for h in right.values / G for v in (h.real, h.imag, one)]
    names = ";".join(f"Re(H {n}) [g/N];Im(H {n}) [g/N];γ²({n})" for n in ("a1", "a2"))
    rows = [row.replace(".", ",") for row in cells(";", right.frequency, *parts)]
    return Known(save(folder, ["Frequenz [Hz];" + names, *rows]), frf=right, rejected="γ²")
