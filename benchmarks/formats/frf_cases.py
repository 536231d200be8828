"""FRFs of analysers as text."""

from pathlib import Path

import numpy as np
from known import DISPLACEMENT, VELOCITY, G, Known, KnownFrf, case, inertance, receptance

LINES = np.arange(20.0, 220.0, 0.5)


def save(
    folder: Path, head: list[str], columns: list[np.ndarray], between: str = ",", decimal: str = "."
) -> tuple[str, ...]:
    rows = [between.join(f"{v:.8g}".replace(".", decimal) for v in row) for row in np.array(columns).T]
    (folder / "case.csv").write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")
    return ("case.csv",)


def plain(lines: np.ndarray = LINES) -> KnownFrf:
    return KnownFrf(lines, inertance(lines)[:, 0])


def polar(h: np.ndarray, degrees: bool = True) -> tuple[np.ndarray, np.ndarray]:
    return np.abs(h), np.degrees(np.angle(h)) if degrees else np.unwrap(np.angle(h))


@case("frf table")
def kilohertz_unwrapped(folder: Path) -> Known:
    """Lines in kHz, phases in rad, unwrapped, decimal comma and semicolons."""
    right = plain()
    (m1, p1), (m2, p2) = (polar(h, False) for h in right.values)
    head = "Frequency [kHz];Mag a1;Phase a1 [rad];Mag a2;Phase a2 [rad]"
    return Known(save(folder, [head], [LINES / 1e3, m1, p1 - 4 * np.pi, m2, p2], ";", ","), frf=right)


@case("frf table")
def decibels_of_g(folder: Path) -> Known:
    """Levels in dB that refer to 1 g/N, which the header says."""
    right = plain()
    (m1, p1), (m2, p2) = (polar(h / G) for h in right.values)
    head = "Frequency [Hz],a1 Mag [dB re 1 g/N],a1 Phase [deg],a2 Mag [dB re 1 g/N],a2 Phase [deg]"
    return Known(
        save(folder, [head], [LINES, 20 * np.log10(m1), p1, 20 * np.log10(m2), p2]), frf=right, rejected=r"dB re 1 g/N"
    )


@case("frf table")
def magnitude_in_g(folder: Path) -> Known:
    """Coherence first, phases before magnitudes, g/N."""
    right = plain()
    (m1, p1), (m2, p2) = (polar(h / G) for h in right.values)
    head = "Frequency (Hz),Coherence a1,Phase a1 (°),Magnitude a1 (g/N),Coherence a2,Phase a2 (°),Magnitude a2 (g/N)"
    c = 1 - 0.01 * np.exp(-LINES / 100)
    right = KnownFrf(right.frequency, right.values, coherence=np.array([c, c]))
    return Known(save(folder, [head], [LINES, c, p1, m1, c, p2, m2]), frf=right)


@case("frf table")
def mobility_parts(folder: Path) -> Known:
    """Mobilities, real and imaginary, of velocity channels, mm/s/N."""
    h = 2j * np.pi * LINES * receptance(LINES)[:, 0]
    columns = [LINES, *(part for row in h * 1e3 for part in (row.real, row.imag))]
    head = "Frequency [Hz];a1 Real [mm/s/N];a1 Imag [mm/s/N];a2 Real [mm/s/N];a2 Imag [mm/s/N]"
    return Known(save(folder, [head], columns, ";"), frf=KnownFrf(LINES, h, "mobility"), rig=VELOCITY)


@case("frf table")
def receptance_complex(folder: Path) -> Known:
    """Receptances in µm/N as complex numbers with exponents, `1.2E+01-3.4E+00i`."""
    h = receptance(LINES)[:, 0]
    rows = [
        f"{f:g}\t" + "\t".join(f"{1e6 * v.real:.8E}{1e6 * v.imag:+.8E}i" for v in row)
        for f, row in zip(LINES, h.T, strict=True)
    ]
    (folder / "case.txt").write_text(
        "Frequency [Hz]\ta1 [µm/N]\ta2 [µm/N]\n" + "\n".join(rows) + "\n", encoding="utf-8"
    )
    return Known(("case.txt",), frf=KnownFrf(LINES, h, "receptance"), rig=DISPLACEMENT)


@case("frf table")
def inertance_of_displacements(folder: Path) -> Known:
    """The header says µm/N, the rig has accelerometers: receptances, never taken as m/s^2/N."""
    h = receptance(LINES)[:, 0]
    columns = [LINES, *(1e6 * part for row in h for part in (row.real, row.imag))]
    head = "Frequency [Hz],Re a1 [µm/N],Im a1 [µm/N],Re a2 [µm/N],Im a2 [µm/N]"
    return Known(save(folder, [head], columns), frf=KnownFrf(LINES, h, "receptance"))


@case("frf table")
def swept_down(folder: Path) -> Known:
    """A sweep downwards: lines from high to low."""
    right = plain()
    columns = [LINES[::-1], *(part[::-1] for row in right.values for part in (row.real, row.imag))]
    return Known(
        save(folder, ["Frequency,Re a1,Im a1,Re a2,Im a2"], columns), frf=right, rejected="(?i)ascend|descend|order"
    )


@case("frf table")
def from_zero(folder: Path) -> Known:
    """The first line is 0 Hz, magnitude 0 and phase 0."""
    lines = np.arange(0, 200.0, 0.5)
    right = plain(lines)
    (m1, p1), (m2, p2) = (polar(h) for h in right.values)
    head = "Frequency [Hz],a1 Mag,a1 Phase [deg],a2 Mag,a2 Phase [deg]"
    return Known(save(folder, [head], [lines, m1, p1, m2, p2]), frf=right)


@case("frf table")
def log_lines_radians_per_second(folder: Path) -> Known:
    """Lines evenly spaced on a log scale, in rad/s."""
    lines = np.geomspace(20, 200, 300)
    right = plain(lines)
    columns = [2 * np.pi * lines, *(part for row in right.values for part in (row.real, row.imag))]
    return Known(
        save(folder, ["omega [rad/s]\tRe a1\tIm a1\tRe a2\tIm a2"], columns, "\t"),
        frf=right,
        rejected="(?i)first column|frequency",
        tolerance=1e-5,
    )


@case("frf table")
def analyser_tags(folder: Path) -> Known:
    """Tags of an analyser above the rows; the second column counts lines."""
    right = plain()
    tags = [
        "Title1:\tFrequency Response H1",
        "Application:\tPULSE",
        "Date:\t29/03/2026",
        "Header Size:\t9",
        "X-axis unit:\tHz",
    ]
    tags += ["X-axis size:\t400", "X-axis first:\t20", "X-axis delta:\t0.5", "Data type:\tComplex"]
    columns = [LINES, *(part for row in right.values for part in (row.real, row.imag))]
    return Known(save(folder, [*tags, "Frequency [Hz]\ta1 Real\ta1 Imag\ta2 Real\ta2 Imag"], columns, "\t"), frf=right)


@case("frf table")
def decimal_degrees_comma(folder: Path) -> Known:
    """dB and degrees with decimal comma, units in a line of their own."""
    right = plain()
    (m1, p1), (m2, p2) = (polar(h) for h in right.values)
    head = ["Frequency;Gain a1;Phase a1;Gain a2;Phase a2", "[Hz];[dB];[deg];[dB];[deg]"]
    return Known(save(folder, head, [LINES, 20 * np.log10(m1), p1, 20 * np.log10(m2), p2], ";", ","), frf=right)
