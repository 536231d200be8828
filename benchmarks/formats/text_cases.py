"""Text files of loggers, oscilloscopes and spreadsheets."""

from collections.abc import Callable
from pathlib import Path

from known import DISPLACEMENT, PLAIN, RATE, VELOCITY, VOLTS, G, Known, Record, case, hit

HEAD = "time [s],force [N],a1 [m/s^2],a2 [m/s^2]"


def lines_of(record: Record, time: Callable[[int], str], cell: Callable[[float], str], between: str) -> list[str]:
    return [between.join([time(i), *(cell(v) for v in row)]) for i, row in enumerate(record.rows.T)]


def save(
    folder: Path, lines: list[str], encoding: str = "utf-8", ending: str = "\n", name: str = "case.csv"
) -> tuple[str, ...]:
    (folder / name).write_text(ending.join(lines) + ending, encoding=encoding, newline="")
    return (name,)


def seconds(i: int) -> str:
    return f"{i / RATE:.6f}"


def plain(value: float) -> str:
    return f"{value:.6f}"


def comma(value: float) -> str:
    return f"{value:.6f}".replace(".", ",")


def german(value: float) -> str:
    """1234567.891 as 1.234.567,891."""
    return f"{value:,.4f}".translate(str.maketrans(",.", ".,"))


@case("text")
def quoted_german_thousands(folder: Path) -> Known:
    """Everything quoted, semicolons, comma as decimal mark, points between thousands; forces in mN."""
    record = hit()
    head = '"time [s]";"force [mN]";"a1 [mm/s^2]";"a2 [mm/s^2]"'
    rows = [
        ";".join(f'"{c}"' for c in (german(i / RATE), *(german(1e3 * v) for v in row)))
        for i, row in enumerate(record.rows.T)
    ]
    return Known(save(folder, [head, *rows]), (record,))


@case("text")
def swiss_thousands(folder: Path) -> Known:
    """Apostrophes between thousands."""
    record = hit()
    cell = lambda v: f"{1e3 * v:,.3f}".replace(",", "'")  # noqa: E731
    head = "time [s];force [mN];a1 [mm/s^2];a2 [mm/s^2]"
    return Known(save(folder, [head, *lines_of(record, seconds, cell, ";")]), (record,))


@case("text")
def units_without_brackets(folder: Path) -> Known:
    """A second line of units without brackets, a third of numbers of channels."""
    record = hit()
    head = ["Time;force;a1;a2", "ms;kN;g;m/s²"]
    rows = [f"{1e3 * i / RATE:.4f};{f / 1e3:.9f};{a / G:.8f};{b:.6f}" for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(save(folder, [*head, *rows]), (record,))


@case("text")
def trailing_in_rows_only(folder: Path) -> Known:
    """A separator at the end of each row, none at the end of the header."""
    record = hit()
    return Known(save(folder, [HEAD, *(row + "," for row in lines_of(record, seconds, plain, ","))]), (record,))


@case("text")
def shorter_last_column(folder: Path) -> Known:
    """The last channel has seven samples less: its cells are empty there."""
    record = hit()
    rows = lines_of(record, seconds, plain, ",")
    rows[-7:] = [row.rsplit(",", 1)[0] + "," for row in rows[-7:]]
    return Known(save(folder, [HEAD, *rows]), (record.part(0, -7),), rejected=r"(?i)line 10\d\d|a2")


@case("text")
def cut_in_a_number(folder: Path) -> Known:
    """Cut off within the last row."""
    rows = [HEAD, *lines_of(hit(), seconds, plain, ",")]
    (folder / "case.csv").write_text("\n".join(rows)[:-14], encoding="utf-8")
    return Known(("case.csv",), rejected=r"(?i)cut off|columns|line 10\d\d")


@case("text")
def unicode_text_of_a_spreadsheet(folder: Path) -> Known:
    """UTF-16 with a byte order mark, tabs, decimal comma, CR LF."""
    record = hit()
    rows = lines_of(record, lambda i: comma(i / RATE), comma, "\t")
    return Known(save(folder, [HEAD.replace(",", "\t"), *rows], "utf-16", "\r\n", "case.txt"), (record,))


@case("text")
def separator_line(folder: Path) -> Known:
    """`sep=;` above the header, and a byte order mark of UTF-8."""
    record = hit()
    rows = lines_of(record, lambda i: comma(i / RATE), comma, ";")
    return Known(save(folder, ["sep=;", HEAD.replace(",", ";"), *rows], "utf-8-sig", "\r\n"), (record,))


@case("text")
def word_for_missing(folder: Path) -> Known:
    """`#N/A` in one cell."""
    rows = lines_of(hit(), seconds, plain, ",")
    rows[500] = rows[500].rsplit(",", 1)[0] + ",#N/A"
    return Known(save(folder, [HEAD, *rows]), rejected=r"(?is)(line 502|a2).*#N/A|#N/A.*(line 502|a2)")


@case("text")
def infinite(folder: Path) -> Known:
    """An oscilloscope's word for beyond the range, `-∞`, in two cells."""
    rows = lines_of(hit(), seconds, plain, ",")
    rows[70] = rows[70].rsplit(",", 1)[0] + ",-∞"
    return Known(
        save(folder, [HEAD, *rows]), rejected=r"(?is)(line 72|a2|0\.035).*(∞|inf|range)|(∞|inf).*(line 72|a2|0\.035)"
    )


@case("text")
def inf_word(folder: Path) -> Known:
    """`Inf` in one cell."""
    rows = lines_of(hit(), seconds, plain, ",")
    rows[70] = rows[70].rsplit(",", 1)[0] + ",Inf"
    return Known(save(folder, [HEAD, *rows]), rejected=r"(?is)line 72|a2.*(inf|finite)")


@case("text")
def not_a_number_word(folder: Path) -> Known:
    """`1.#QNAN` in one cell, as a C library of old wrote it."""
    rows = lines_of(hit(), seconds, plain, ",")
    rows[71] = rows[71].rsplit(",", 1)[0] + ",1.#QNAN"
    return Known(save(folder, [HEAD, *rows]), rejected=r"(?is)line 73|a2.*(nan|finite|number|missing)")


@case("text")
def oscilloscope_volts(folder: Path) -> Known:
    """Channels A to C, ms and V and mV in a line of their own, an empty line, volts of sensors."""
    record = hit()
    rows = [
        f"{1e3 * (i / RATE - 0.02):.5f},{f * 0.01:.9f},{a * 10:.6f},{b * 10:.6f}"
        for i, (f, a, b) in enumerate(record.rows.T)
    ]
    head = ["Time,Channel A,Channel B,Channel C", "(ms),(V),(mV),(mV)", ""]
    names = ("--variable", "force=Channel A", "a1=Channel B", "a2=Channel C")
    return Known(save(folder, [*head, *rows]), (record,), options=("--drive-point", "1", *names), rig=VOLTS)


@case("text")
def oscilloscope_facts_above(folder: Path) -> Known:
    """Facts in pairs above the header, numbers among them: `Record Length,1024`; one line of units, kN and g."""
    record = hit()
    written = Record(record.force / 1e3, record.a1 / G, record.a2 / G)
    facts = [
        "Model,MSO44",
        "Firmware Version,1.2.3",
        "",
        "Waveform Type,ANALOG,,",
        "Point Format,Y,,",
        "Horizontal Units,s,,",
    ]
    facts += [
        "Sample Interval,5e-04,,",
        "Record Length,1024,,",
        "Zero Index,60,,",
        "Vertical Units,kN,g,g",
        ",,,",
        "Label,,,",
    ]
    rows = lines_of(written, lambda i: f"{i / RATE - 0.03:.5e}", lambda v: f"{v:.7g}", ",")
    return Known(save(folder, [*facts, "TIME,force,a1,a2", *rows]), (record,))


@case("text")
def memory_recorder(folder: Path) -> Known:
    """Quoted tags in lines of pairs, one of them units, then `DATA`, then rows of a time and the signals."""
    record = hit()
    written = Record(record.force, record.a1 / G, record.a2 / G)
    head = ['"COMMENT",', '"8807 MEM DATA"', '"DATE",', '"03-29-2026"', '"TIME",', '"15:26:55"', '"NUM_SIGS",', "4"]
    head += ['"INTERVAL",', "5.000E-04", '"HORZ_UNITS","S"', '"VERT_UNITS","S","N","g","g"']
    head += ['"SIGNAL",', '"TIME","force","a1","a2"', '"DATA"']
    rows = lines_of(written, lambda i: f"{i / RATE:.4E}", lambda v: f"{v:+.6E}", ", ")
    return Known(save(folder, [*head, *rows]), (record,))


@case("text")
def index_and_extra_columns(folder: Path) -> Known:
    """A column of sample numbers first, a temperature and words last."""
    record = hit()
    rows = [f"{i},{row},21.5,ok" for i, row in enumerate(lines_of(record, seconds, plain, ","))]
    head = "Sample,Time (s),force (N),a1 (m/s^2),a2 (m/s^2),temperature (°C),state"
    return Known(save(folder, [head, *rows]), (record,), says=r"(?s)Sample.*temperature.*state")


@case("text")
def fortran_table(folder: Path) -> Known:
    """Blanks between columns, exponents with D, a header behind `#`."""
    record = hit()
    rows = [
        "  " + "  ".join(f"{v: .9E}".replace("E", "D") for v in (i / RATE, *row)) for i, row in enumerate(record.rows.T)
    ]
    return Known(save(folder, ["# time force a1 a2", *rows], name="case.dat"), (record,))


@case("text")
def micrometres(folder: Path) -> Known:
    """Displacements in µm, the sign of micro once as U+00B5 and once as U+03BC."""
    record = hit(derivatives=0)
    rows = [f"{i / RATE:.5f};{f:.6f};{a * 1e6:.7f};{b * 1e6:.7f}" for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(save(folder, ["time [s];force [N];a1 [\u00b5m];a2 [\u03bcm]", *rows]), (record,), rig=DISPLACEMENT)


@case("text")
def pounds_and_inches(folder: Path) -> Known:
    """Force in lbf, velocities in in/s."""
    record = hit(derivatives=1)
    rows = [
        f"{i / RATE:.5f},{f / 4.4482216152605:.9f},{a / 0.0254:.9f},{b / 0.0254:.9f}"
        for i, (f, a, b) in enumerate(record.rows.T)
    ]
    return Known(
        save(folder, ["time [s],force [lbf],a1 [in/s],a2 [in/s]", *rows]), (record,), rig=VELOCITY, rejected=r"in/s"
    )


@case("text")
def metres_where_accelerations_are(folder: Path) -> Known:
    """A column in mm where the rig has an acceleration: rejected."""
    rows = lines_of(hit(derivatives=0), seconds, lambda v: f"{v * 1e3:.9f}", ",")
    return Known(save(folder, ["time [s],force [N],a1 [mm],a2 [mm]", *rows]), rejected=r"mm", rig=PLAIN)


@case("text")
def force_upside_down(folder: Path) -> Known:
    """A channel whose direction is against the drive is turned."""
    record = hit()
    rows = lines_of(Record(record.force, record.a1, -record.a2), seconds, plain, ",")
    rig = PLAIN.replace("point: 2}", "point: 2, direction: -z}", 2)
    return Known(save(folder, [HEAD, *rows]), (record,), rig=rig)
